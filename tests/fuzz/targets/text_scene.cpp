#include "fuzz/target.h"
#include "fuzz/targets/imported_file.h"

namespace tessera::fuzz {

const Target kTextScene = {"text_scene",
                           [](std::string_view bytes) { return accepts_file(bytes, "textproto"); }};

}  // namespace tessera::fuzz
