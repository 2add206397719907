// The image file that a command was asked for.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "image/exr.h"
#include "image/exr/rows.h"
#include "image/image.h"
#include "image/view/display_view.h"

namespace tessera::client {

/// InvalidArgument, before any work is done, when `path` is neither .exr nor .png, in capitals or not, or
/// cannot be written.
absl::Status check_output(const std::string& path);

/// Likewise, and where `exr` has all views in one file that is none.
absl::Status check_output(const std::string& path, const ExrFormat& exr);

/// The same for a file of any kind.
absl::Status check_writable(const std::string& path);

/// Whether the name of a file says so.
bool is_exr(const std::string& path);

/// Chooses the format by extension: a linear EXR, or a PNG for screens.
absl::Status write_image(const Image& image, const std::string& path, const ExrFormat& exr = {},
                         const ViewOptions& view = {});
/// The same of an image whose planes have names, but no values: those are `rows`.
absl::Status write_image(const Image& image, Rows& rows, const std::string& path, const ExrFormat& exr = {});

}  // namespace tessera::client
