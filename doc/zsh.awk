# Completion for zsh from the tool's help texts.
#
#   help.sh ./hbil | awk -f help.awk -f words.awk -f zsh.awk

function quoted(text) {
  gsub(/'/, "'\\''", text)
  return text
}

function about(text) {
  gsub(/[\[\]:\\]/, "\\\\&", text)
  return quoted(text)
}

function argument(name, flag,    kind, action) {
  kind = kind_of[name, flag]
  action = ""
  if (kind == "word" || (kind == "other" && words_of[name, flag] != ""))
    action = ":value:(" words_of[name, flag] ")"
  else if (kind == "list")
    action = ":list:_sequence compadd - " words_of[name, flag]
  else if (kind == "device")
    action = ":device:_hbil_devices"
  else if (kind == "folder")
    action = ":folder:_files -/"
  else if (kind == "file")
    action = ":file:_files"
  else if (kind == "other")
    action = ":value: "
  return "      '" flag "[" about(about_of[name, flag]) "]" action "' \\"
}

function write_completion(    i, j, count, flag_count, name, flag) {
  print "#compdef hbil"
  print "# Completion of hbil for zsh; written by the build from its help texts."
  print "_hbil_devices() {"
  print "  compadd -- ${(f)\"$($_hbil_program devices 2>/dev/null |" \
    " sed -n 's/^ *\\([0-9]*\\)  .*/\\1/p')\"}"
  print "}"
  print "local _hbil_program=$words[1]"
  print "if ((CURRENT == 2)); then"
  print "  local -a commands=("
  count = split(names, name, " ")
  for (i = 1; i <= count; i++)
    print "    '" name[i] ":" about(abouts[name[i]]) "'"
  print "  )"
  print "  _describe command commands"
  print "  compadd -- " flags_of[""]
  print "else"
  print "  local command=$words[2]"
  print "  shift words\n  ((CURRENT--))"
  print "  case $command in"
  for (i = 1; i <= count; i++) {
    print "  " name[i] ")\n    _arguments \\"
    flag_count = split(flags_of[name[i]], flag, " ")
    for (j = 1; j <= flag_count; j++)
      print argument(name[i], flag[j])
    print "      " (operands_of[name[i]] ? "'*:file:_files'" : "") " ;;"
  }
  print "  esac\nfi"
}
