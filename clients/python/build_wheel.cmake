# Makes the wheel of PACKAGE in TO, with the setuptools of Debian's python3 or of the first one found;
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
execute_process(
  COMMAND ${python} -c "import sys; from setuptools import build_meta; build_meta.build_wheel(sys.argv[1])" ${TO}
  WORKING_DIRECTORY ${WORK} OUTPUT_VARIABLE said ERROR_VARIABLE said RESULT_VARIABLE code)
if(code)
  message(FATAL_ERROR "the wheel was not made:\n${said}")
endif()
file(GLOB wheel ${TO}/*.whl)
message(STATUS "${wheel}")
