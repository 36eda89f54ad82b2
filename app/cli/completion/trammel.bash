# Completion of trammel for bash: the program itself says what can stand at the cursor.
# Read it once:  source <(trammel completion bash)

_trammel() {
  local words=() lines=() word line k
  COMPREPLY=()
  # bash breaks words at = and :, the program does not.
  for ((k = 1; k <= COMP_CWORD; ++k)); do
    word=${COMP_WORDS[k]//[\"\'\\]/}
    if ((k > 1)) && { [[ $word == [=:]* ]] || [[ ${words[-1]} == *[=:] ]]; }; then
      words[-1]+=$word
    else
      words+=("$word")
    fi
  done
  local typed=${words[-1]}
  local kept=${typed%"${typed##*[=:]}"} # what bash leaves alone in front of the completed piece
  mapfile -t lines < <("${COMP_WORDS[0]/#\~/$HOME}" complete -- "${words[@]}" 2>/dev/null)
  ((${#lines[@]})) || return 0
  local paths=${lines[-1]}
  unset 'lines[-1]'
  for line in "${lines[@]}"; do
    word=${line%%$'\t'*}
    printf -v word %q "${word#"$kept"}"
    COMPREPLY+=("$word")
  done
  if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *: ]]; then compopt -o nospace 2>/dev/null; fi
  case $paths in
    :files) mapfile -t lines < <(compgen -f -- "${typed##*[=:]}") ;;
    :folders) mapfile -t lines < <(compgen -d -- "${typed##*[=:]}") ;;
    *) return 0 ;;
  esac
  if ((${#lines[@]})); then
    compopt -o filenames 2>/dev/null
    COMPREPLY+=("${lines[@]}")
  fi
}
complete -F _trammel trammel
