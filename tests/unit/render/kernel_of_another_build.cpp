// A module that looks like one with kernels, of another build; TESSERA_BUILD_NAME is that build's, if it has
// one. Its entry point ends the program: nobody may call it.
#include <cstdlib>

extern "C" {
#ifdef TESSERA_BUILD_NAME
extern __attribute__((visibility("default"))) const char tessera_kernel_build[];
const char tessera_kernel_build[] = TESSERA_BUILD_NAME;
#endif
__attribute__((visibility("default"))) const void* tessera_kernel() { std::abort(); }
}
