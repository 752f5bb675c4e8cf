# The debugger as editors meet it.
foreach(class Sessions Stops LongRuns Damage Recorded CommandLine)
  string(TOLOWER ${class} name)
  add_test(NAME dap_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/dap_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(dap_${name} PROPERTIES TIMEOUT 300)
endforeach()
# And as VS Code's own test client does: the package @vscode/debugadapter-testsupport, where somebody has installed it.
set(CLAYMELD_DAP_CLIENT "" CACHE PATH "A folder whose node_modules have @vscode/debugadapter-testsupport, for one more test")
if(CLAYMELD_DAP_CLIENT)
  add_test(NAME dap_testsupport COMMAND node ${CMAKE_CURRENT_LIST_DIR}/testsupport.js $<TARGET_FILE:meldsim> ${CLAYMELD_DAP_CLIENT})
  set_tests_properties(dap_testsupport PROPERTIES TIMEOUT 300)
endif()
