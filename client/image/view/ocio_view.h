// Views of OpenColorIO's configurations.
#pragma once

#include "image/view/display_view.h"

namespace tessera::client {

/// InvalidArgument where OpenColorIO does not take the configuration, or it has no such display, view or
/// space; FailedPrecondition where the module with OpenColorIO is not there.
absl::StatusOr<std::unique_ptr<DisplayView>> make_ocio_view(const ViewOptions& options);

}  // namespace tessera::client
