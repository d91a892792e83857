find_package(ZLIB REQUIRED)

target_link_libraries(test_points PRIVATE isoextract_extract isoextract_accuracy ZLIB::ZLIB)
