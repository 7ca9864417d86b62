# Converts a program's --help (CLI11's format) to scdoc: its options, positionals and commands, each
# name with its text below; groups of options with their names. Variable `want`: "options", "more" (the same without --help), or
# "commands" (only their names).
function escape(text) {
  gsub(/\\/, "\\\\", text)
  gsub(/[*_<>`#~\[\]]/, "\\\\&", text)
  return text
}
# "-s,--style TEXT Excludes: --mix" with the names in bold.
function name(head, i, end, names) {
  end = match(head, / /) ? RSTART : length(head) + 1
  names = substr(head, 1, end - 1)
  sub(/\{false\}/, "", names)
  gsub(/,/, ", ", names)
  sub(/FLOAT:FLOAT/, "FLOAT", head)
  sub(/INT:INT/, "INT", head)
  return "*" escape(names) "*" (end <= length(head) ? " " escape(substr(head, end + 1)) : "")
}
function skip() {
  head = text = ""
}
function flush() {
  if (head == "") return
  if (want != "commands" && section != "Subcommands:") {
    if (want == "more" && head ~ /^-h,--help/) return skip()
    print name(head)
    print "\t" (text == "" ? "See DESCRIPTION." : escape(text) (text ~ /[.!?]$/ ? "" : "."))
    print ""
  } else if (want == "commands" && section == "Subcommands:") {
    print head
  }
  skip()
}
{ lines[++count] = $0 }
END {
  blank = sprintf("%30s", "")
  for (i = 1; i <= count; ++i) {
    line = lines[i]
    if (line ~ /^[A-Z][a-z]*:$/) {
      flush()
      section = line
      group = line ~ /^(Start|Data|Network|Losses|Schedule|Machine|Output):$/
      known = group || line ~ /^(Options|Positionals|Subcommands):$/
      if (group && want != "commands") print "*" substr(line, 1, length(line) - 1) "*\n"
    } else if (line !~ /^  /) {
      flush()
      if (line != "") known = 0
    } else if (known && line ~ /^  [^ ]/) {
      flush()
      # The text starts at column 31 behind a blank, or on the next line if the name is longer. Without
      # a text a long name may have its type there.
      if (substr(lines[i + 1], 1, 30) == blank || substr(line, 30) !~ /^ [^ ]/ ||
          substr(line, 31) ~ /^(TEXT|INT|UINT|FLOAT|BOOLEAN)([^A-Za-z]|$)/) {
        head = substr(line, 3)
      } else {
        head = substr(line, 3, 28)
        text = substr(line, 31)
      }
      sub(/ +$/, "", head)
    } else if (known) {
      sub(/^ +/, "", line)
      text = text (text == "" ? "" : " ") line
    }
  }
  flush()
}
