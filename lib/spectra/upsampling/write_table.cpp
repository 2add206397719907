// Writes the program's table of sigmoids as a source: write_table FILE.
#include <cstdio>
#include <vector>

#include "spectra/upsampling/fit_table.h"
#include "spectra/upsampling/own_table.h"

int main(int argc, char** argv) {
  std::FILE* const file = argc == 2 ? std::fopen(argv[1], "w") : nullptr;
  if (file == nullptr) {
    std::fputs("usage: write_table FILE, which can be written\n", stderr);
    return 1;
  }
  std::fputs(
      "#include \"spectra/upsampling/own_table.h\"\n\nnamespace tessera::spectra {\n\n"
      "alignas(16) const float kOwnRows[kOwnRowFloats] = {\n",
      file);
  // Hexadecimal: every float is written as it is.
  for (const float number : tessera::spectra::fit_table(tessera::spectra::kOwnResolution))
    std::fprintf(file, "%af,\n", double{number});
  std::fputs("};\n\n}  // namespace tessera::spectra\n", file);
  return std::fclose(file) == 0 ? 0 : 1;
}
