# Run as a script: cmake -DPAGE=index.html -DSTYLE=style.css -DSCRIPT=page.js -DEARLY=early.js -DOUT=page.html -P JoinPage.cmake
# Writes the page with the style and the scripts in it, where it has {{style}}, {{early}} and {{script}}.
file(READ ${PAGE} page)
foreach(part STYLE EARLY SCRIPT)
  file(READ ${${part}} text)
  string(TOLOWER ${part} name)
  string(FIND "${page}" "{{${name}}}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "${PAGE} has no {{${name}}}")
  endif()
  string(REPLACE "{{${name}}}" "${text}" page "${page}")
endforeach()
file(WRITE ${OUT} "${page}")
