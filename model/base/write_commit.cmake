# cmake -D SOURCE=tree -D OUT=header [-D COMMIT=text] -P write_commit.cmake: writes the tree's commit, for
# version.cpp. A header that would stay the same is not touched, so that nothing is built again. COMMIT: of a tree
# without git, given at configuration.
set(commit "${COMMIT}")
# Not the commit of another repository that the tree was unpacked into.
if(NOT commit AND EXISTS ${SOURCE}/.git)
  # The tree may be another user's, as in a chroot.
  set(git git -c safe.directory=* -C ${SOURCE})
  execute_process(COMMAND ${git} rev-parse --short=12 HEAD
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(failed)
    set(commit "")
  else()
    execute_process(COMMAND ${git} status --porcelain --untracked-files=no
      OUTPUT_VARIABLE changes ERROR_QUIET RESULT_VARIABLE failed)
    if(failed OR NOT changes STREQUAL "")
      string(APPEND commit ", changed")
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT "#pragma once\n#define STYLED_COMMIT \"${commit}\"\n" @ONLY)
