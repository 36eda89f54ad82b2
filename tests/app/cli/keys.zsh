# Types each argument and TAB into an interactive zsh that has read ./trammel.zsh, and prints what the
# line is then.
zmodload zsh/zpty
zpty typed zsh -f -i
zpty -w typed 'unsetopt zle_bracketed_paste; autoload -Uz compinit; compinit -u -D; source ./trammel.zsh
show() { print -r -- "<<$BUFFER>>"; BUFFER= }; zle -N show; bindkey "^X" show; print REA""DY'
zpty -r typed out '*READY*'
for line in "$@"; do
  zpty -w -n typed "$line"$'\t\x18'
  zpty -r typed out '*<<*>>*'
  print -r -- "${${out##*<<}%%>>*}"
done
zpty -d typed
