# Debian packages by CPack, one for each part; systemd/packages.sh builds them.
set(STYLED_PACKAGE_MAINTAINER "Styled maintainers <maintainers@styled.invalid>"
  CACHE STRING "Name and address in the Debian packages")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME styled)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${STYLED_PACKAGE_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_COMPONENTS_ALL daemon tools web cpp python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_BINARY_DIR}/finish_packages.cmake)
configure_file(finish_packages.cmake.in finish_packages.cmake @ONLY)

# package(COMPONENT NAME SECTION SUMMARY TEXT [DEPENDS..] [RECOMMENDS..]): maintainer scripts are what
# systemd/debian/NAME has.
function(package component name section summary text)
  cmake_parse_arguments(ARG "" "DEPENDS;RECOMMENDS;SUGGESTS" "" ${ARGN})
  string(TOUPPER ${component} c)
  file(GLOB scripts CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/debian/${name}/*)
  if(STYLED_ARCH STREQUAL x86-64-v3 AND component MATCHES "daemon|tools|web")
    list(APPEND scripts ${CMAKE_CURRENT_SOURCE_DIR}/debian/preinst)
  endif()
  set(CPACK_DEBIAN_${c}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_DEPENDS "${ARG_DEPENDS}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_RECOMMENDS "${ARG_RECOMMENDS}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_SUGGESTS "${ARG_SUGGESTS}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${c}_PACKAGE_CONTROL_EXTRA "${scripts}" PARENT_SCOPE)
  install(FILES debian/copyright DESTINATION share/doc/${name} COMPONENT ${component})
  # As a changelog of Debian wants it; packed, like manual pages, by finish_packages.cmake.
  string(TIMESTAMP DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
  set(PACKAGE ${name})
  configure_file(debian/changelog.in ${name}.changelog @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.changelog
    DESTINATION share/doc/${name} RENAME changelog COMPONENT ${component})
endfunction()

package(daemon styled non-free/video "restyles live motion capture"
"styled takes the frames of motion capture rigs over the network or USB, puts
each into another style with a recurrent network before the next one arrives,
and publishes the styled skeleton over ZeroMQ.
.
This package has the daemon, its systemd units, udev rules and shipped weights.
The weights are licensed CC BY-NC 4.0: not for commercial use."
  DEPENDS "systemd | systemd-standalone-sysusers | systemd-sysusers"
  RECOMMENDS "styled-tools (= ${PROJECT_VERSION})"
  SUGGESTS "styled-web, udev")
package(tools styled-tools video "control, monitor and simulate a styled daemon"
"stylectl controls a styled daemon and finds out why nothing arrives, stylemon
shows its performers in a terminal, stylerec records, plays back and exports,
stylevmc forwards to applications that speak VMC, stylesim stands in for a rig,
stylize restyles BVH files."
  RECOMMENDS "styled (= ${PROJECT_VERSION})")
package(web styled-web video "gateway and viewer of a styled daemon for browsers"
"styleweb shows what a styled daemon does in browsers and lets them control it,
and serves its metrics to Prometheus."
  RECOMMENDS "styled (= ${PROJECT_VERSION})")
# The headers that protoc made go with one series of its library.
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
asyncio. python3 -m styled tail shows what is published."
  DEPENDS "python3 (>= 3.9), python3-protobuf, python3-zmq")
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_CPP_PACKAGE_SHLIBDEPS OFF)

include(CPack)
