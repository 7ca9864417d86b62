# Completion of Styled's programs in bash, on file names, options, commands; on styles, presets and
# performers of the daemon that runs. What can be completed is asked of the programs themselves (--help),
# so it is never older than they are.

declare -gA _styled_said=()

# What "$@" --help says, into REPLY; asked once in a session.
_styled_ask_help() {
  [[ -n ${_styled_said["$*"]-} ]] || _styled_said["$*"]=$("$@" --help 2>/dev/null)
  REPLY=${_styled_said["$*"]}
}

# The help of a program, into REPLY; of the command among its words first, if there is one.
_styled_help() {
  local program=$1 word all
  shift
  _styled_ask_help "$program"
  all=$REPLY
  for word in "$@"; do
    if [[ $word != -* && $all == *$'\nSubcommands:'*$'\n  '"$word "* ]]; then
      _styled_ask_help "$program" "$word"
      REPLY+=$'\n'${all%%$'\n'Subcommands:*}
      return
    fi
  done
}

# Of a help text: every option, and every command.
_styled_options() {
  awk '/^(Options|Subcommands):/{on=1; next} /^[^ ]/{on=0}
       on && /^  [^ ]/{sub(/\{false\}/, "", $1); gsub(/\{false\},?/, ",", $1)
                       n = split($1, names, ","); for (i = 1; i <= n; ++i) if (names[i] != "") print names[i]}'
}

# Of a help text: the words that the option $1 may be followed by, where it names them: {t,n}.
_styled_choices() {
  awk -v option="$1" '/^  -/{n = split($1, names, ","); rest = substr($0, 3 + length($1))
       for (i = 1; i <= n; ++i) if (names[i] == option && match(rest, /\{[^}]*\}/)) {
         words = substr(rest, RSTART + 1, RLENGTH - 2); gsub(/,/, "\n", words); print words }}'
}

# What the daemon says. Silence where there is none.
_styled_ask() { "${_styled_folder}stylectl" --timeout 0.5 --json "$1" 2>/dev/null; }
_styled_styles() { _styled_ask list | sed 's/.*"styles"://' | _styled_values name; }
_styled_presets() { _styled_ask list | sed 's/.*"presets"://; s/"styles":.*//' | _styled_values name; }
_styled_cues() { _styled_ask list | sed 's/.*"cues"://; s/"ok":.*//' | _styled_values name | sort -u; }
_styled_performers() { _styled_ask status | _styled_values performer | sort -u; }
_styled_values() { grep -o "\"$1\":\"[^\"]*\"" | cut -d'"' -f4; }

_styled_complete() {
  local program=$1 current=$2 previous=$3 help words word REPLY
  local _styled_folder=
  [[ $program == */* ]] && _styled_folder=${program%/*}/
  COMPREPLY=()
  _styled_help "$program" "${COMP_WORDS[@]:1:COMP_CWORD-1}"
  help=$REPLY
  case $previous in
    --style | --mix | -s | -m | --from)
      if [[ ${program##*/} == stylectl || ${program##*/} == stylize ]]; then
        if [[ ${program##*/} == stylize ]]; then
          words=$("$program" --list 2>/dev/null | tr -d ,)
        else
          words=$(_styled_styles)
        fi
      fi
      ;;
    --performer) words=$(_styled_performers) ;;
    preset) words=$(_styled_presets) ;;
    cue) words=$(_styled_cues) ;;
    -*) words=$(_styled_choices "$previous" <<<"$help") ;;
    set | clear | pin | unpin | reset | calibrate)
      [[ ${program##*/} == stylectl ]] && words="$(_styled_performers) *"
      ;;
  esac
  local values=$words
  if [[ $current == -* || -z $words ]]; then
    words+=$'\n'$(_styled_options <<<"$help")
  fi
  # No compgen -W: it would expand what a daemon calls its styles.
  while IFS= read -r word; do
    [[ -n $word && $word == "$current"* ]] && COMPREPLY+=("$(printf %q "$word")")
  done < <(tr ' ' '\n' <<<"$words")
  if [[ $current != -* && -z $values ]]; then
    while IFS= read -r word; do COMPREPLY+=("$word"); done < <(compgen -f -- "$current")
    compopt -o filenames 2>/dev/null
  fi
}

complete -F _styled_complete styled stylectl stylemon stylesim stylerec stylevmc styleweb stylize \
  styletrain styleeval
