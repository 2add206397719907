# cmake -DOUT=FILE.cpp -DVERSION=V -DHEADERS="a;b" -P kernel_build.cmake: a source with the name of the build that
# programs and kernel modules must have in common (kernel_module.h).
set(digests)
foreach(header ${HEADERS})
  file(SHA256 ${header} digest)
  string(APPEND digests ${digest})
endforeach()
string(SHA256 digest "${digests}")
string(SUBSTRING ${digest} 0 12 digest)
file(WRITE ${OUT} "extern \"C\" {
extern __attribute__((visibility(\"default\"))) const char tessera_kernel_build[];
const char tessera_kernel_build[] = \"${VERSION}-${digest}\";
}
")
