# Writes the rows of kLookFields (FROM, proto/styled/look.h) as the Python module TO. A literal with its escapes, and
# several in a row, mean the same in both languages.
file(READ ${FROM} text)
string(REPLACE ";" "<semicolon>" text "${text}")
set(name "\"[a-z_]*\"")
string(REGEX MATCHALL "{${name}, ${name}, ${name},[ \n]*(\"([^\"\\]|\\\\.)*\"[ \n]*)+," rows "${text}")
set(module "\"\"\"The options of a look: field, (word, former word, help). Made of proto/styled/look.h.\"\"\"\n\nLOOK_OPTIONS = {\n")
foreach(row IN LISTS rows)
  string(REGEX REPLACE "{(${name}), (${name}), (${name}),[ \n]*(.*),$" "    \\1: (\\2, \\3, \\4),\n" row "${row}")
  string(APPEND module "${row}")
endforeach()
string(REPLACE "<semicolon>" ";" module "${module}")
file(WRITE ${TO} "${module}}\n")
