#include "fuzz/target.h"
#include "fuzz/targets/imported_file.h"

namespace tessera::fuzz {

const Target kPbrt = {"pbrt", [](std::string_view bytes) { return accepts_file(bytes, "pbrt"); }};

}  // namespace tessera::fuzz
