# Completion for bash from the tool's help texts.
#
#   help.sh ./hbil | awk -f help.awk -f words.awk -f bash.awk

# The shell code that completes a value.  Files and folders are left to
# readline's own completion, which handles spaces and tildes.
function value_action(name, flag,    action) {
  action = ""
  if (kind_of[name, flag] == "list")
    return " _hbil_list '" words_of[name, flag] "' \"$2\";"
  if (kind_of[name, flag] == "device")
    return " _hbil_words \"$(\"$1\" devices 2>/dev/null | sed -n 's/^ *\\([0-9]*\\)  .*/\\1/p')\" \"$2\";"
  if (words_of[name, flag] != "")
    action = " _hbil_words '" words_of[name, flag] "' \"$2\";"
  if (kind_of[name, flag] == "file")
    action = action " compopt -o default;"
  if (kind_of[name, flag] == "folder")
    action = action " compopt -o dirnames;"
  return action
}

function write_completion(    i, j, count, flag_count, name, flag) {
  print "# Completion of hbil for bash; written by the build from its help texts."
  print "_hbil_words() {"
  print "  mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$2\")\n}"
  print "# The words of a list that begin like what is behind its last comma."
  print "_hbil_list() {"
  print "  local before="
  print "  [[ $2 == *,* ]] && before=${2%,*},"
  print "  mapfile -t COMPREPLY < <(compgen -P \"$before\" -W \"$1\" -- \"${2##*,}\")"
  print "  compopt -o nospace\n}"
  print "_hbil() {"
  print "  local command=${COMP_WORDS[1]}"
  print "  COMPREPLY=()"
  print "  compopt +o default"
  print "  if ((COMP_CWORD == 1)); then"
  print "    _hbil_words '" names " " flags_of[""] "' \"$2\""
  print "    return"
  print "  fi"
  print "  case \"$command $3\" in"
  count = split(names, name, " ")
  for (i = 1; i <= count; i++) {
    flag_count = split(flags_of[name[i]], flag, " ")
    for (j = 1; j <= flag_count; j++)
      if (kind_of[name[i], flag[j]] != "")
        print "  '" name[i] " " flag[j] "')" \
          value_action(name[i], flag[j]) " return ;;"
  }
  print "  esac"
  print "  case $command/$2 in"
  for (i = 1; i <= count; i++) {
    print "  " name[i] "/-*) _hbil_words '" flags_of[name[i]] "' \"$2\" ;;"
    if (operands_of[name[i]])
      print "  " name[i] "/*) compopt -o default ;;"
  }
  print "  esac\n}"
  print "complete -o default -F _hbil hbil"
}
