#compdef trammel
# Completion of trammel for zsh: the program itself says what can stand at the cursor.
# Read it once:  source <(trammel completion zsh)

_trammel() {
  local -a lines words_before found
  local line word
  words_before=("${(@Q)words[2,CURRENT-1]}")
  lines=("${(@f)$(${(Q)~words[1]} complete -- "${(@)words_before}" "${(Q)PREFIX}" 2>/dev/null)}")
  for line in "${(@)lines[1,-2]}"; do
    word=${line%%$'\t'*}
    if [[ $word == *: ]]; then
      compadd -S '' -- "$word"
    else
      found+=("${word//:/\\:}:${line#*$'\t'}")
    fi
  done
  (( $#found )) && _describe -V trammel found
  case $lines[-1] in
    :files) compset -P '*[=:]'; _files ;;
    :folders) compset -P '*[=:]'; _files -/ ;;
  esac
}
if [[ $funcstack[1] == _trammel ]]; then _trammel "$@"; else compdef _trammel trammel; fi
