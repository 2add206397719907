#include "fuzz/target.h"
#include "fuzz/targets/imported_file.h"

namespace tessera::fuzz {

const Target kMitsuba = {"mitsuba", [](std::string_view bytes) { return accepts_file(bytes, "xml"); }};

}  // namespace tessera::fuzz
