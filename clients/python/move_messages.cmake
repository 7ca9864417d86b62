# Moves protoc's modules, and their types, of proto.styled.v1 from FROM to the package styled.v1 in TO.
file(GLOB modules RELATIVE ${FROM} ${FROM}/*_pb2.py ${FROM}/*_pb2.pyi)
foreach(module ${modules})
  file(READ ${FROM}/${module} text)
  string(REPLACE "proto.styled.v1" "styled.v1" text "${text}")
  file(WRITE ${TO}/${module} "${text}")
endforeach()
file(WRITE ${TO}/__init__.py
  "\"\"\"The messages, as proto/styled/v1 documents them. Made by protoc.\"\"\"\n")
