#!/bin/sh
# make_page.sh PROGRAM PAGE VERSION [EMULATOR]: prints the page as input for scdoc. @VERSION@ becomes VERSION;
# the line @OPTIONS@ becomes the --help of PROGRAM and of each of its commands; a line @OPTIONS words@
# becomes the lines that `PROGRAM words --help` prints and `PROGRAM --help` does not; a line @FILE path@
# becomes that file. EMULATOR runs the program where it is for another processor.
set -eu
program=$1 page=$2 version=$3 emulator=${4:-}
here=$(dirname "$0")
unset STYLED_DATA  # a default of some programs; the page is of none's

# options WANT PROGRAM [COMMAND]
options() {
  want=$1
  shift
  $emulator "$@" --help | awk -v want="$want" -f "$here/options.awk"
}

while IFS= read -r line; do
  case $line in
    @OPTIONS@)
      options options "$program"
      for command in $(options commands "$program"); do
        printf '## %s %s\n\n' "$(basename "$program")" "$command"
        $emulator "$program" "$command" --help | sed -n '1s/[*_]/\\&/g;1p'
        echo
        options more "$program" "$command"
      done
      ;;
    "@OPTIONS "*)
      words=${line#@OPTIONS }
      { options options "$program"; echo "@"; echo; options options "$program" ${words%@}; } |
        awk 'BEGIN { RS = "" } $0 == "@" { more = 1; group = ""; next } /^\*[A-Z][a-z]+\*$/ { group = $0 "\n\n"; next }
             !more { said[$0]; next } !($0 in said) { print group $0 "\n"; group = "" }'
      ;;
    "@FILE "*)
      file=${line#@FILE }
      cat "$here/${file%@}"
      ;;
    *) printf '%s\n' "$line" | sed "s/@VERSION@/$version/g" ;;
  esac
done <"$page"
