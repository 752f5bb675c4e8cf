# The blocks of aggregate programming in stdlib/, disturbed, and the examples that are made of them, beside networkx.
foreach(block field cast collect multipath leaders channel partition gossip countdown crf bis flex
        adaptive_channel crowd_alert sensor_areas evacuation drone_formation)
  meld_sizes_test(fields_${block} ${CMAKE_CURRENT_LIST_DIR}/fields_test.py $<TARGET_FILE:meldsim> ${block})
endforeach()
