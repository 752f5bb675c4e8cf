# The server of the viewer, without a browser.
add_test(NAME view_server COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/server_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
meld_sizes_test(view_frames ${CMAKE_CURRENT_LIST_DIR}/frames_test.py --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME view_abuse COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/abuse_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(view_server view_abuse PROPERTIES TIMEOUT 180 PROCESSORS 2)
# The page of the viewer, in a browser, a class of tests an entry.
foreach(class page/Seen page/Drawn page/Steered help/Helped read/Legible)
  get_filename_component(file ${class} DIRECTORY)
  get_filename_component(class ${class} NAME)
  string(TOLOWER ${class} name)
  add_test(NAME view_page_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/${file}_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(view_page_${name} PROPERTIES TIMEOUT 180 PROCESSORS 2)
endforeach()
