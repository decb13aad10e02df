# SPDX-License-Identifier: MIT
# bash completion of pipewright and pipewrightd: words and options as --help tells them.
_pipewright() {
  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}
  local program=${COMP_WORDS[0]} word= i
  case $before in
    --config | --socket | --scenario | --faults | --out | --mcap | --depth)
      mapfile -t COMPREPLY < <(compgen -f -- "$current")
      return
      ;;
  esac
  local -a path=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    [[ ${COMP_WORDS[i]} == -* ]] && break
    # Only words that the program knows lead deeper; a file's name does not.
    "$program" "${path[@]}" --help 2>/dev/null | grep -qE "^  ${COMP_WORDS[i]//[^a-z]/} " || break
    path+=("${COMP_WORDS[i]}")
  done
  word=$("$program" "${path[@]}" --help 2>/dev/null |
    awk -v options="$([[ $current == -* ]] && echo 1)" '
      /^Subcommands:/ { sub_words = 1; next }
      sub_words && !options && /^  [a-z]/ { print $1 }
      options && /^  (-[a-zA-Z],)?--?[a-z]/ { n = split($1, o, ","); for (k = 1; k <= n; k++) print o[k] }')
  mapfile -t COMPREPLY < <(compgen -W "$word" -- "$current")
  [[ ${#COMPREPLY[@]} -gt 0 || $current == -* ]] || mapfile -t COMPREPLY < <(compgen -f -- "$current")
}
complete -F _pipewright pipewright pipewrightd
