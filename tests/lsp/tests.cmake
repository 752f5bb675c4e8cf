# The language server, in scripted sessions.
foreach(class Life Texts Questions Names Actions Hostile)
  string(TOLOWER ${class} name)
  add_test(NAME lsp_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/lsp_test.py --meldc $<TARGET_FILE:meldc> ${class})
endforeach()
add_test(NAME lsp_costs COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/costs_test.py --meldc $<TARGET_FILE:meldc>
  --meldsim $<TARGET_FILE:meldsim>)
