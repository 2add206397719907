// Participating media of a scene's messages -> MediumTable.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/medium/medium_table.h"
#include "render/scene/blob_source.h"
#include "render/scene/medium/medium_names.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/spectral/spectral_builder.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

class MediumBuilder {
 public:
  using Media = google::protobuf::RepeatedPtrField<v1::Medium>;

  /// Grids of samples come from `blobs`.
  /// `spectral`: for jobs of wavelengths only, else null.
  MediumBuilder(const RenderSpace& space, const BlobSource& blobs, MediumTable& table,
                SpectralBuilder* spectral = nullptr)
      : space_(space), blobs_(blobs), table_(table), spectral_(spectral) {}

  /// Adds all media; none, with a warning, where `algorithm` sees none. InvalidArgument names the medium.
  absl::Status build(const Media& media, const wire::AlgorithmTraits& algorithm,
                     std::vector<std::string>& warnings);
  /// Adds one medium. InvalidArgument does not name it.
  absl::Status add(const v1::Medium& medium);
  const MediumNames& names() const { return names_; }

 private:
  absl::Status build_medium(const v1::Medium& medium, MediumRecord& record);
  absl::Status set_quantities(const v1::Medium& medium, MediumRecord& record);
  /// The curves of those that were measured, of what set_quantities() has set.
  void set_curves(const v1::Medium& medium, MediumRecord& record);
  /// The albedo of a medium that is the same everywhere, and has sigma_s so far.
  void divide_by_extinction(MediumRecord& record);
  /// Where the medium is, and bounds of its density there.
  absl::Status set_bounds(const v1::Medium& medium, int grid, MediumRecord& record);
  absl::Status set_value(const v1::VolumeValue& value, float otherwise, float scale, MediumValue& result);
  absl::StatusOr<int> add_grid(const v1::VolumeGrid& grid);
  /// To the unit cube that the matrix places.
  absl::StatusOr<Affine> unit_cube_from_render(const v1::Matrix& world_from_cube) const;

  const RenderSpace& space_;
  const BlobSource& blobs_;
  MediumTable& table_;
  SpectralBuilder* const spectral_;
  MediumNames names_;
};

}  // namespace tessera::render
