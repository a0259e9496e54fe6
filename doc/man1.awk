# hbil(1) from the tool's help texts, and examples: paragraphs of text, and
# indented commands.
# help2man (1.49) was tried: it makes a page of one --help, so the sub-commands have
# no place in it, and it writes no completion.
#
#   help.sh ./hbil |
#     awk -v version=V -v examples=FILE -f roff.awk -f help.awk -f man1.awk

function at_command(name, about) {
  if (name == "") {
    print page_head("hbil", 1)
    print ".SH NAME\nhbil \\- horizon-based indirect lighting of G-buffers"
  } else {
    print ".SH HBIL " toupper(name) "\n" \
      toupper(substr(about, 1, 1)) prose_line(substr(about, 2)) "."
  }
  first_command = name == ""
  paragraph = 0
}

function at_usage(text) {
  if (first_command)
    print ".SH SYNOPSIS"
  else
    print ".PP"
  print ".B " code_line(text)
  if (first_command)
    print ".SH DESCRIPTION"
}

function at_heading(text) {
  print ".SS " prose_line(text)
  paragraph = 0
}

function at_prose(text) {
  if (text == "") {
    paragraph = 0
    return
  }
  if (sub(/^Exit status: /, "", text))
    print first_command ? ".SH EXIT STATUS" : ".SS Exit status"
  else if (!paragraph)
    print ".PP"
  paragraph = 1
  print prose_line(text)
}

function at_item(name, text) {
  print ".TP\n.B " code_line(name) "\n" prose_line(text)
  paragraph = 0
}

function at_option(flags, value, text) {
  gsub(/ /, ", ", flags)
  print ".TP\n\\fB" code_line(flags) "\\fR" \
    (value == "" ? "" : " \\fI" code_line(value) "\\fR")
  print prose_line(text)
  paragraph = 0
}

function write_examples(    line, is_code, was_code) {
  print ".SH EXAMPLES"
  while ((getline line <examples) > 0) {
    is_code = sub(/^    /, "", line)
    if (is_code && !was_code)
      print ".PP\n.RS\n.nf"
    if (!is_code && was_code)
      print ".fi\n.RE\n.PP"
    if (is_code)
      print code_line(line)
    else if (line != "")
      print prose_line(line)
    was_code = is_code
  }
  if (was_code)
    print ".fi\n.RE"
}

function at_end() {
  write_examples()
  print ".SH ENVIRONMENT\n.TP\n.B HBIL_KERNEL_DIR"
  print "folder from which the kernels are read in place of those that the"
  print "library has inside; for work on them."
  print ".TP\n.B HBIL_PROGRAM_DIR"
  print "folder in which built programs are stored for later runs, with any"
  print "driver; if it is empty, none are stored."
  print ".SH FILES\n.TP\n.I $XDG_CACHE_HOME/hbil, $HOME/.cache/hbil"
  print "built programs, if HBIL_PROGRAM_DIR isn\\(aqt set and the driver doesn\\(aqt"
  print "store them itself.  The folder must belong to the user, and nobody else"
  print "may have the right to write there.  It has at most 256 MiB; it may be"
  print "deleted at any time."
  print ".SH SEE ALSO\n.BR hbil (3),\n.BR clinfo (1),\n.BR oiiotool (1)"
}
