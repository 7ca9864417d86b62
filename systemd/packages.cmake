# Debian packages by CPack, one for each part; systemd/packages.sh builds them.
set(STYLED_PACKAGE_MAINTAINER "Styled maintainers <maintainers@styled.invalid>"
  CACHE STRING "Name and address in the Debian packages")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME styled)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
# Packages of one version for two Debians are two packages: a repository holds both, and apt takes those of the new
# Debian when a system is upgraded. In the way of Debian's own updates: 0.2.0+deb12 < 0.2.0+deb13 < 0.2.1.
cmake_host_system_information(RESULT system QUERY DISTRIB_INFO)
string(REGEX REPLACE "^\\+debian" "+deb" of "+${system_ID}${system_VERSION_ID}")
if(NOT of MATCHES "^[+][a-z]+[0-9.]+$")
  set(of "")
endif()
set(deb_version ${PROJECT_VERSION}${of})
set(CPACK_DEBIAN_PACKAGE_VERSION ${deb_version})
if(CMAKE_CROSSCOMPILING)  # CPack takes the architecture of the machine that builds
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
endif()
set(CPACK_PACKAGE_CONTACT "${STYLED_PACKAGE_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_COMPONENTS_ALL)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
# Debian's changelogs, copyright files and notices are made while packing (finish_packages.py).
find_package(Python3 QUIET COMPONENTS Interpreter)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_BINARY_DIR}/finish_packages.cmake)
configure_file(finish_packages.cmake.in finish_packages.cmake @ONLY)

# package(COMPONENT NAME SECTION SUMMARY TEXT [DEPENDS..] [RECOMMENDS..] [SUGGESTS..] [ENHANCES..]
# [REPLACES..] [DOCS NAME=file...]): maintainer scripts are taken from systemd/debian/NAME. REPLACES: packages, at versions,
# that had some of its files. DOCS: documents and their names in share/doc; finish_packages.py reads them here, too, and
# gives links between them these names.
function(package component name section summary text)
  cmake_parse_arguments(ARG "" "DEPENDS;RECOMMENDS;SUGGESTS;ENHANCES;REPLACES" "DOCS" ${ARGN})
  string(TOUPPER ${component} c)
  file(GLOB scripts CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/debian/${name}/*)
  if(STYLED_ARCH STREQUAL x86-64-v3 AND component MATCHES "daemon|tools|web|train")
    list(APPEND scripts ${CMAKE_CURRENT_SOURCE_DIR}/debian/preinst)
  endif()
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  foreach(relation DEPENDS RECOMMENDS SUGGESTS ENHANCES REPLACES)
    set(CPACK_DEBIAN_${c}_PACKAGE_${relation} "${ARG_${relation}}" PARENT_SCOPE)
  endforeach()
  set(CPACK_DEBIAN_${c}_PACKAGE_BREAKS "${ARG_REPLACES}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_CONTROL_EXTRA "${scripts}" PARENT_SCOPE)
  # The folder's name tells finish_packages.py the package; it makes the package's own file of this.
  install(FILES debian/copyright DESTINATION share/doc/${name} COMPONENT ${component})
  foreach(document ${ARG_DOCS})
    string(REPLACE "=" ";" document ${document})
    list(GET document 0 as)
    list(GET document 1 file)
    install(FILES ${PROJECT_SOURCE_DIR}/${file} DESTINATION share/doc/${name} RENAME ${as} COMPONENT ${component})
  endforeach()
endfunction()

set(card MODEL-CARD.md=model/weights/README.md)
set(wire WIRE.md=proto/styled/v1/WIRE.md)
package(daemon styled video "restyles live motion capture"
"styled takes the frames of motion capture rigs over the network or USB, puts
each into another style with a recurrent network before the next one arrives,
and publishes the styled skeleton over ZeroMQ.
.
This package has the daemon, its systemd units, udev rules and the weights
open: fourteen styles that may be used commercially, with credits. Styles that
may not are in styled-weights-nc."
  DEPENDS "systemd | systemd-standalone-sysusers | systemd-sysusers"
  RECOMMENDS "styled-tools (= ${deb_version})"
  SUGGESTS "styled-weights-nc, styled-web, udev"
  DOCS OPERATING.md=daemon/OPERATING.md TROUBLESHOOTING.md=daemon/TROUBLESHOOTING.md GLOSSARY.md=daemon/GLOSSARY.md
       STANDBY.md=daemon/standby/README.md SECURITY.md=daemon/security/README.md ${wire} ${card})
package(weights_nc styled-weights-nc non-free/video "styles for styled, not for commercial use"
"Weights that were trained on motions of Bandai Namco: v2, with fifteen styles,
graph, which makes styles of examples live, and st-gcn, for recorded clips.
.
They are licensed CC BY-NC 4.0: not for commercial use. A monetized stream is
counted as such."
  ENHANCES "styled, styled-tools"
  REPLACES "styled (<< 0.2.0)"
  DOCS ${card})
set(CPACK_DEBIAN_WEIGHTS_NC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_WEIGHTS_NC_PACKAGE_SHLIBDEPS OFF)
package(tools styled-tools video "control, monitor and simulate a styled daemon"
"stylectl controls a styled daemon and finds out why nothing arrives, stylemon
shows its performers in a terminal, stylerec records, plays back and exports,
stylevmc forwards to applications that speak VMC, stylenats to NATS servers,
styleoscquery lets VRChat and VMC programs find the daemon in the network,
stylesim stands in for a rig, stylize restyles BVH files."
  RECOMMENDS "styled (= ${deb_version})"
  SUGGESTS avahi-daemon)
package(web styled-web video "gateway and viewer of a styled daemon for browsers"
"styleweb shows what a styled daemon does in browsers and lets them control it,
and serves its metrics to Prometheus."
  RECOMMENDS "styled (= ${deb_version})"
  DOCS README.md=clients/web/README.md WEBSOCKET.md=clients/web/WIRE.md)
# Headers generated by protoc work only with one release series of its library.
find_package(Protobuf REQUIRED)
string(REGEX MATCH "^([0-9]+)[.]([0-9]+)" protobuf "${Protobuf_VERSION}")
math(EXPR next_minor "${CMAKE_MATCH_2} + 1")
set(protobuf "libprotobuf-dev (>= ${protobuf}), libprotobuf-dev (<< ${CMAKE_MATCH_1}.${next_minor}~)")
package(cpp libstyled-client-dev libdevel "C++ client library of a styled daemon"
"Headers and static libraries to subscribe to styled motion and to control a
styled daemon, for CMake (find_package) and pkg-config, and the messages'
definitions for other languages."
  DEPENDS "libeigen3-dev, ${protobuf}, libzmq3-dev")
package(python python3-styled python "Python client library of a styled daemon"
"Subscribes to styled motion and controls a styled daemon, plain and with
asyncio. python3 -m styled tail shows what is published. With libstyled it
restyles clips without a daemon."
  DEPENDS "python3 (>= 3.9), python3-protobuf, python3-zmq"
  SUGGESTS "libstyled${PROJECT_VERSION_MAJOR}, python3-numpy"
  DOCS ${wire})
# The trainer's, where libtorch was found.
if(TARGET styletrain)
  package(train styled-train video "train and judge styles for styled"
"styletrain trains a network of styles on clips of motion, styleeval judges it,
stylerefine fits a style that was made of an example, styleunseen and styleacts
measure styles and acts that no training saw, stylestrip draws them."
    SUGGESTS "styled-tools (= ${deb_version})")
endif()
# libstyled, where its install() rules are: components are known by the rules before this.
get_cmake_property(components COMPONENTS)
if(library IN_LIST components AND library_dev IN_LIST components)
  package(library libstyled${PROJECT_VERSION_MAJOR} libs "restyles motion, as a library"
"Puts poses of a skeleton into another style, frame by frame, in the calling
program. Weights are not in it: styled has them."
    SUGGESTS styled)
  package(library_dev libstyled-dev libdevel "restyles motion, as a library: to build with"
"Headers of libstyled, a library with a C interface that puts poses of a
skeleton into another style, for C and C++, CMake (find_package) and pkg-config."
    DEPENDS "libstyled${PROJECT_VERSION_MAJOR} (= ${deb_version})")
  set(CPACK_DEBIAN_LIBRARY_DEV_PACKAGE_SHLIBDEPS OFF)
  set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_CPP_PACKAGE_SHLIBDEPS OFF)

include(CPack)
