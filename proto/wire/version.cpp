#include "wire/version.h"

namespace tessera::wire {

const char* build_version() { return TESSERA_VERSION; }

}  // namespace tessera::wire
