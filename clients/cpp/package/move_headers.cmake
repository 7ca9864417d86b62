# Copies the client's public headers from SOURCE, and protoc's from GENERATED, to TREE, and the
# example to EXAMPLE, and rewrites their includes to the installed paths:
#   clients/cpp/*.h       <styled/client/*.h>        model/body/humanoid.h  <styled/body/humanoid.h>
#   model/base/*.h        <styled/base/*.h>          proto/styled/v1/*      <styled/v1/*>
function(move from to)
  file(READ ${from} text)
  string(REGEX REPLACE "#include \"clients/cpp/([^\"]*)\"" "#include <styled/client/\\1>" text "${text}")
  string(REGEX REPLACE "#include \"model/([^\"]*)\"" "#include <styled/\\1>" text "${text}")
  string(REGEX REPLACE "#include \"proto/styled/([^\"]*)\"" "#include <styled/\\1>" text "${text}")
  file(WRITE ${to} "${text}")
endfunction()

foreach(header subscriber control transforms curve reach)
  move(${SOURCE}/clients/cpp/${header}.h ${TREE}/client/${header}.h)
endforeach()
foreach(header hash status)
  move(${SOURCE}/model/base/${header}.h ${TREE}/base/${header}.h)
endforeach()
move(${SOURCE}/model/body/humanoid.h ${TREE}/body/humanoid.h)
foreach(message body checkpoint fate frame look control stats)
  move(${GENERATED}/proto/styled/v1/${message}.pb.h ${TREE}/v1/${message}.pb.h)
endforeach()
move(${SOURCE}/clients/cpp/example.cpp ${EXAMPLE})
