# The viewer's page, made of the modules in this folder and three.js, as one file without anything beside it.
if(NOT CLAYMELD_VIEWER)
  return()
endif()
find_program(ESBUILD esbuild REQUIRED)
find_file(THREE_MODULE three.module.js PATHS /usr/share/javascript/three/build REQUIRED NO_DEFAULT_PATH)
foreach(tool ESBUILD THREE_MODULE)
  if(NOT EXISTS "${${tool}}")
    message(FATAL_ERROR "there is no ${${tool}}, which the page of the viewer is made with: set ${tool} to it, or CLAYMELD_VIEWER to OFF")
  endif()
endforeach()

set(page_source ${CMAKE_SOURCE_DIR}/runtime/show/view/page)
set(page_output ${CMAKE_BINARY_DIR}/generated/runtime/show/view/page)
file(MAKE_DIRECTORY ${page_output})
file(GLOB page_modules CONFIGURE_DEPENDS ${page_source}/*.js ${page_source}/drawn/*.js)
add_custom_command(
  OUTPUT ${page_output}/page.html
  COMMAND ${ESBUILD} ${page_source}/main.js --bundle --minify --format=iife --target=es2020 --log-level=warning
    --alias:three=${THREE_MODULE} --outfile=${page_output}/page.js
  COMMAND ${ESBUILD} ${page_source}/early.js --bundle --minify --format=iife --target=es2020 --log-level=warning
    --outfile=${page_output}/early.js
  COMMAND ${CMAKE_COMMAND} -DPAGE=${page_source}/index.html -DSTYLE=${page_source}/style.css -DSCRIPT=${page_output}/page.js
    -DEARLY=${page_output}/early.js -DOUT=${page_output}/page.html -P ${CMAKE_SOURCE_DIR}/cmake/JoinPage.cmake
  DEPENDS ${page_modules} ${page_source}/index.html ${page_source}/style.css ${CMAKE_SOURCE_DIR}/cmake/JoinPage.cmake
  VERBATIM)
meld_embed(runtime/show/view/page TEXT kPage ${page_output}/page.html)
