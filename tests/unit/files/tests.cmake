isoextract_unit_test(files content_hash_test.cpp mapped_file_test.cpp output_change_test.cpp output_file_test.cpp standard_input_test.cpp
  temporary_name_test.cpp opened_files_test.cpp gzip_stream_test.cpp)
