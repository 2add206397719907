#include "import/mitsuba/image_size.h"

#include <OpenImageIO/imageio.h>

#include "import/input/concat.h"

namespace tessera::client::mitsuba {

absl::StatusOr<ImageSize> read_image_size(const std::filesystem::path& path) {
  const auto input = OIIO::ImageInput::open(path.string());
  if (!input) return absl::InvalidArgumentError(concat(path.string(), ": ", OIIO::geterror()));
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1) return absl::InvalidArgumentError(concat(path.string(), ": an empty image"));
  return ImageSize{spec.width, spec.height};
}

}  // namespace tessera::client::mitsuba
