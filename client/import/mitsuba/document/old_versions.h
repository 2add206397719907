// Scenes written for versions of Mitsuba before 2.
#pragma once

#include <string>
#include <string_view>

#include "import/mitsuba/document/values.h"

namespace tessera::client::mitsuba {

/// toWorld -> to_world, as Mitsuba 3 converts names.
std::string underscore_case(std::string_view camel_case);

/// Renames what has another name now, and turns uscale, vscale, uoffset and voffset into to_uv.
void upgrade_from_version_1(Object& object);

}  // namespace tessera::client::mitsuba
