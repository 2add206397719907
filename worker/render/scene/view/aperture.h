// Apertures of lenses that are pictures.
#pragma once

#include "absl/status/statusor.h"
#include "render/scene/blob_source.h"
#include "render/sensor/lens_table.h"
#include "tessera/v1/blob_ref.pb.h"

namespace tessera::render {

/// The aperture that the image file is a picture of. InvalidArgument where it is none, lets no light through,
/// or has more than 4096 pixels in a row or column.
absl::StatusOr<AperturePicture> aperture_picture(const v1::BlobRef& image, const BlobSource& blobs);

}  // namespace tessera::render
