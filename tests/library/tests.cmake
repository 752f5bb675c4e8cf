# The libraries of stdlib/, each with a program that feeds it, in several worlds and on several numbers of processes and threads.
foreach(library gradient tree convergecast broadcast leader timers mis mis_late colouring colouring_late flood khop terminated)
  add_test(NAME library_${library}
           COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/library_test.py $<TARGET_FILE:meldsim> ${CMAKE_CURRENT_LIST_DIR} ${library})
  set_tests_properties(library_${library} PROPERTIES TIMEOUT 600 PROCESSORS 2)
endforeach()
