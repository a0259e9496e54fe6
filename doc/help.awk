# Reads help texts (help.sh) and calls a function for each of their parts, in
# order.  The functions are in the script that follows on awk's command line:
#
#   at_command(name, about)        the text of a command begins; the program's
#                                  own text has the name ""
#   at_usage(text)                 the text after "usage: "
#   at_heading(text)               a line that ends in a colon, followed by options
#   at_prose(text)                 a line of prose; "" between paragraphs
#   at_item(name, text)            a command in the program's help
#   at_option(flags, value, text)  flags with spaces between; value may be ""
#   at_end()
#
# A help text begins with "usage: ".  Prose and headings begin in the first
# column.  Options and commands are indented, and their descriptions begin in
# column 25, on the next line if the option is long (options_help.c).

function trimmed(text) {
  gsub(/^ +| +$/, "", text)
  return text
}

# Splits an option's line into `head` and `tail`.
function split_option(text) {
  head = text
  tail = ""
  if (length(text) > 24 && substr(text, 24, 1) == " ") {
    head = substr(text, 1, 24)
    tail = substr(text, 25)
  }
  head = trimmed(head)
}

function hand_over_option(    flags, value, word, words, count, i) {
  count = split(head, words, " ")
  flags = value = ""
  for (i = 1; i <= count; i++) {
    word = words[i]
    sub(/,$/, "", word)
    if (word ~ /^-/)
      flags = flags (flags == "" ? "" : " ") word
    else
      value = value (value == "" ? "" : " ") word
  }
  if (flags == "")
    at_item(head, tail)
  else
    at_option(flags, value, tail)
}

function hand_over(    i, open) {
  open = 0
  for (i = 1; i <= lines; i++) {
    if (open && line[i] ~ /^          +/) {
      tail = tail (tail == "" ? "" : " ") trimmed(line[i])
      continue
    }
    if (open)
      hand_over_option()
    open = 0
    if (line[i] ~ /^usage: /)
      at_usage(substr(line[i], 8))
    else if (line[i] ~ /^ +[^ ]/) {
      split_option(line[i])
      open = 1
    } else if (line[i] ~ /^[^ ].*:$/ && line[i - 1] == "" && line[i + 1] ~ /^ /)
      at_heading(substr(line[i], 1, length(line[i]) - 1))
    else
      at_prose(line[i])
  }
  if (open)
    hand_over_option()
}

function about_command(name,    i) {
  for (i = 1; i <= items; i++)
    if (item[i] == name)
      return item_text[i]
  return ""
}

function end_command() {
  if (!begun)
    return
  at_command(name, about_command(name))
  hand_over()
  lines = 0
}

# The program's own help lists the commands, with the text that at_command() gets.
name == "" && /^  [a-z]+ / {
  items++
  item[items] = $1
  item_text[items] = $0
  sub(/^ *[a-z]+ */, "", item_text[items])
}

/^== / { end_command(); name = substr($0, 4); begun = 1; next }

{ line[++lines] = $0 }

END { end_command(); at_end() }
