# Functions that write text for man pages.

# Escapes a line of prose.
function prose_line(text) {
  gsub(/\\/, "\\e", text)
  gsub(/--/, "\\-\\-", text)
  gsub(/ -/, " \\-", text)
  gsub(/\(-/, "(\\-", text)
  sub(/^-/, "\\-", text)
  gsub(/`/, "\\(ga", text)
  gsub(/\^/, "\\(ha", text)
  gsub(/~/, "\\(ti", text)
  if (text ~ /^[.']/)
    text = "\\&" text
  return text
}

# Escapes a line of code, so that it can be copied from the page.
function code_line(text) {
  gsub(/\\/, "\\e", text)
  gsub(/-/, "\\-", text)
  gsub(/'/, "\\(aq", text)
  gsub(/`/, "\\(ga", text)
  gsub(/\^/, "\\(ha", text)
  gsub(/~/, "\\(ti", text)
  if (text ~ /^\./)
    text = "\\&" text
  return text
}

function page_head(name, section) {
  return ".\\\" Written by the build; change its source instead.\n" \
    ".TH " name " " section " \"\" \"hbil " version "\" \"hbil\""
}
