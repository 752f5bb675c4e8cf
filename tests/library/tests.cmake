# The libraries of stdlib/, each with a program that feeds it, in several worlds and on several numbers of processes and threads.
foreach(library gradient tree convergecast broadcast leader timers mis mis_late colouring colouring_late flood khop terminated fifo)
  meld_sizes_test(library_${library} ${CMAKE_CURRENT_LIST_DIR}/library_test.py $<TARGET_FILE:meldsim> ${CMAKE_CURRENT_LIST_DIR} ${library})
endforeach()
