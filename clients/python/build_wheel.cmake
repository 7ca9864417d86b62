# Makes the wheel of PACKAGE in TO, with LIBRARY (libstyled.so) and WEIGHTS (a list of files) in it if LIBRARY is
# given: then for this platform alone. It is made with the setuptools of Debian's python3 or of the first one found;
# nothing is downloaded.
foreach(candidate /usr/bin/python3 python3)
  execute_process(COMMAND ${candidate} -c "import setuptools, wheel" RESULT_VARIABLE lacks
                  OUTPUT_QUIET ERROR_QUIET)
  if(lacks EQUAL 0)
    set(python ${candidate})
    break()
  endif()
endforeach()
if(NOT python)
  message(FATAL_ERROR "a wheel needs setuptools: apt install python3-setuptools python3-wheel")
endif()
file(REMOVE_RECURSE ${WORK} ${TO})
file(COPY ${PACKAGE}/ DESTINATION ${WORK} PATTERN __pycache__ EXCLUDE)
file(MAKE_DIRECTORY ${TO})
if(LIBRARY)
  file(COPY_FILE ${LIBRARY} ${WORK}/styled/libstyled.so.0)
  # The other libraries are on every Linux; libstyled looks for libhwy beside itself first.
  file(GET_RUNTIME_DEPENDENCIES LIBRARIES ${LIBRARY} RESOLVED_DEPENDENCIES_VAR needed PRE_INCLUDE_REGEXES libhwy
       PRE_EXCLUDE_REGEXES .)
  foreach(one ${needed})
    get_filename_component(name ${one} NAME)
    get_filename_component(real ${one} REALPATH)
    file(COPY_FILE ${real} ${WORK}/styled/${name})
  endforeach()
  # The weights have licences of their own, which the wheel must name.
  set(licences Apache-2.0)
  foreach(file ${WEIGHTS})
    file(COPY ${file} ${file}.license DESTINATION ${WORK}/styled/weights)
    file(STRINGS ${file}.license line REGEX "^SPDX-License-Identifier: ")
    string(REPLACE "SPDX-License-Identifier: " "" licence "${line}")
    list(APPEND licences ${licence})
  endforeach()
  list(REMOVE_DUPLICATES licences)
  list(JOIN licences " AND " licences)
  file(READ ${WORK}/pyproject.toml text)
  string(REPLACE "text = \"Apache-2.0\"" "text = \"${licences}\"" text "${text}")
  string(REPLACE "\"License :: OSI Approved :: Apache Software License\", " "" text "${text}")
  file(WRITE ${WORK}/pyproject.toml "${text}")
  # For every Python 3: ctypes loads the library, so that it needs no Python's interface.
  file(WRITE ${WORK}/setup.py "from setuptools import setup
from wheel.bdist_wheel import bdist_wheel


class Wheel(bdist_wheel):
    def finalize_options(self):
        super().finalize_options()
        self.root_is_pure = False

    def get_tag(self):
        return 'py3', 'none', super().get_tag()[2]


setup(cmdclass={'bdist_wheel': Wheel})
")
endif()
execute_process(
  COMMAND ${python} -c "import sys; from setuptools import build_meta; build_meta.build_wheel(sys.argv[1])" ${TO}
  WORKING_DIRECTORY ${WORK} OUTPUT_VARIABLE said ERROR_VARIABLE said RESULT_VARIABLE code)
if(code)
  message(FATAL_ERROR "the wheel was not made:\n${said}")
endif()
file(GLOB wheel ${TO}/*.whl)
message(STATUS "${wheel}")
