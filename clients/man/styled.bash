# Bash completion for Styled's programs: file names, options and commands; styles, presets and
# performers of the running daemon. Options and commands come from the programs' --help, so they are
# always current.

declare -gA _styled_said=()

# Stores the output of "$@" --help in REPLY; runs it once per session.
_styled_ask_help() {
  [[ -n ${_styled_said["$*"]-} ]] || _styled_said["$*"]=$("$@" --help 2>/dev/null)
  REPLY=${_styled_said["$*"]}
}

# Stores a program's help in REPLY, preceded by that of the command among its words, if there is
# one.
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

# All options and commands of a help text.
_styled_options() {
  awk '/^(Options|Subcommands|Start|Data|Network|Losses|Schedule|Machine|Output):/{on=1; next} /^[^ ]/{on=0}
       on && /^  [^ ]/{sub(/\{false\}/, "", $1); gsub(/\{false\},?/, ",", $1)
                       n = split($1, names, ","); for (i = 1; i <= n; ++i) if (names[i] != "") print names[i]}'
}

# All commands of a help text.
_styled_commands() { awk '/^Subcommands:/{on=1; next} /^[^ ]/{on=0} on && /^  [^ ]/{print $1}'; }

# The values of option $1 in a help text, if it lists them: {t,n}, or ": native, mocopi, mvn".
_styled_choices() {
  awk -v option="$1" '
    function look() {
      n = split(first, names, ",")
      for (i = 1; i <= n; ++i) if (names[i] == option) {
        if (match(text, /\{[^}]*\}/)) words = substr(text, RSTART + 1, RLENGTH - 2)
        else if (match(text, /: [a-z0-9-]+(, [a-z0-9-]+)+/)) words = substr(text, RSTART + 2, RLENGTH - 2)
        else continue
        gsub(/, */, "\n", words); print words
      }
    }
    /^  -/{look(); first = $1; text = substr($0, 3 + length($1)); next}
    /^   /{text = text " " $0; next}
    {look(); first = ""}
    END{look()}'
}

# Queries the daemon; prints nothing if there is none.
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
  # The command among the words, and the positional arguments after it.
  local command= commands at
  local -a alone=()
  _styled_ask_help "$program"
  commands=$(_styled_commands <<<"$REPLY")
  for ((at = 1; at < COMP_CWORD; ++at)); do
    word=${COMP_WORDS[at]}
    if [[ -z $command && -n $word && $'\n'$commands$'\n' == *$'\n'"$word"$'\n'* ]]; then
      command=$word
    elif [[ -n $command && $word != -* && ${COMP_WORDS[at - 1]} != -* ]]; then
      alone+=("$word")
    fi
  done
  local files=yes
  case $previous in
    --style | --mix | -s | -m | --input-style | --from)
      if [[ ${program##*/} == stylectl || ${program##*/} == stylize ]]; then
        if [[ ${program##*/} == stylize ]]; then
          words=$("$program" --list 2>/dev/null | tr -d ,)
        else
          words=$(_styled_styles)
        fi
      fi
      ;;
    --performer) words=$(_styled_performers) ;;
    -*) words=$(_styled_choices "$previous" <<<"$help") ;;
    *)
      if [[ -n $commands && -z $command ]]; then
        words=$commands files=
      elif [[ ${program##*/} == stylectl ]]; then
        files=
        case $command:${#alone[@]} in
          set:0 | clear:0 | pin:0 | unpin:0 | reset:0 | calibrate:0) words="$(_styled_performers) *" ;;
          preset:0) words="$(_styled_performers) * $(_styled_presets)" ;;
          preset:1)  # a performer has a dot, or is *
            if [[ ${alone[0]} == *[.*]* ]]; then
              words=$(_styled_presets)
            else
              words="$(_styled_performers) *"
            fi
            ;;
          cue:0) words=$(_styled_cues) ;;
          keygen:0) files=yes ;;
        esac
      fi
      ;;
  esac
  local values=$words
  if [[ $current == -* || (-z $words && -z $files) ]]; then
    words+=$'\n'$(_styled_options <<<"$help")
  fi
  # Not compgen -W: it would perform shell expansion on the daemon's names.
  while IFS= read -r word; do
    [[ -n $word && $word == "$current"* ]] && COMPREPLY+=("$(printf %q "$word")")
  done < <(tr ' ' '\n' <<<"$words")
  if [[ $current != -* && -z $values && -n $files ]]; then
    while IFS= read -r word; do COMPREPLY+=("$word"); done < <(compgen -f -- "$current")
    compopt -o filenames 2>/dev/null
  fi
}

complete -F _styled_complete styled stylectl stylemon stylesim stylerec stylevmc stylenats styleoscquery styleweb \
  stylize styletrain styleeval styleunseen stylerefine
