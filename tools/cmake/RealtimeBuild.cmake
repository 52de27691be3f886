# Writes the checksum of the real-time library as a C string: cmake -DLIBRARY=... -DOUTPUT=... -P RealtimeBuild.cmake
file(SHA256 ${LIBRARY} checksum)
file(WRITE ${OUTPUT} "\"${checksum}\"\n")
