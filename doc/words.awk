# Collects what completion offers.  The script that follows on awk's command line
# writes it in write_completion():
#
#   names, abouts[name]            commands, in order, with spaces between
#   flags_of[name]                 all flags of a command
#   words_of[name, flag]           words that a flag takes
#   kind_of[name, flag]            "": no value; "word", "list" (of words, with
#                                  commas), "device", "file", "folder", "other"
#   about_of[name, flag]           the first line about it
#   operands_of[name]              1 if the command takes files

function at_command(name, about) {
  command = name
  abouts[name] = about
  if (name != "")
    names = names (names == "" ? "" : " ") name
}

function at_usage(text) {
  operands_of[command] = command != "" && text ~ /\.exr/
}

function at_heading(text) {}
function at_prose(text) {}
function at_item(name, text) {}

# A value is a choice of words if its name is like yes|no, or one word in small
# letters.  A list's words are in its name, like x,y,z, or at the beginning of its
# text.  All other names stand for values of another kind.
function at_option(flags, value, text,    flag, count, i, kind, words) {
  words = ""
  if (value == "")
    kind = ""
  else if (value ~ /^[a-z0-9]+(\|[a-z0-9]+)*$/) {
    kind = "word"
    words = value
    gsub(/\|/, " ", words)
  } else if (value ~ /^[a-z](,[a-z])+$/ || (value == "LIST" && text ~ /^of /)) {
    kind = "list"
    words = value
    if (value == "LIST") {
      words = substr(text, 4)
      sub(/ \(.*/, "", words)
    }
    gsub(/, */, " ", words)
  } else if (flags ~ /--device/ && value == "NAME")
    kind = "device"
  else if (value ~ /DIR/)
    kind = "folder"
  else if (value ~ /FILE|PNG|\.exr/)
    kind = "file"
  else
    kind = "other"
  count = split(flags, flag, " ")
  for (i = 1; i <= count; i++) {
    if (!((command, flag[i]) in about_of)) {
      flags_of[command] = flags_of[command] \
        (flags_of[command] == "" ? "" : " ") flag[i]
      about_of[command, flag[i]] = text
      kind_of[command, flag[i]] = kind
    } else if (kind == "file" || kind_of[command, flag[i]] == "other")
      kind_of[command, flag[i]] = kind
    if (words != "")
      words_of[command, flag[i]] = words_of[command, flag[i]] \
        (words_of[command, flag[i]] == "" ? "" : " ") words
  }
}

function at_end() {
  write_completion()
}
