// The pictures that somebody looks at.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "service/web/light_meter.h"
#include "service/web/picture.h"
#include "service/web/pixel_units.h"

namespace tessera::server {

class FarmViews;
struct JobShape;

/// A layer of a job's picture, which follows the job's results. Thread-safe.
class ShownPicture {
 public:
  /// Most pixels of one part(), and results, and pixels of theirs, that are read again for it.
  static constexpr std::size_t kMostPartPixels = 256 * 256, kMostReread = 16'384;
  static constexpr std::size_t kMostRereadPixels = std::size_t{1} << 26;

  ShownPicture(FarmViews& views, std::string job, std::shared_ptr<const JobShape> shape, PictureLayer layer);

  /// Takes results that are new, until there are none or it is `deadline`. Whether there may be more at once.
  bool follow(std::chrono::steady_clock::time_point deadline);

  /// Picture::pixels, of any level. InvalidArgument for a part that is not within the picture or too large,
  /// ResourceExhausted where it is made of too many results.
  absl::StatusOr<std::string> part(std::uint32_t level, const PixelArea& pixels);

  /// The bands of radiance of one pixel, means over its samples; without any there are no values.
  struct Spectrum {
    std::vector<double> centres_nm, values;
    std::uint64_t samples = 0;
  };
  /// That of pixel (x, y) of the crop, read from the results again. InvalidArgument where the job has no
  /// bands or the crop no such pixel, ResourceExhausted where the pixel is made of too many results.
  absl::StatusOr<Spectrum> spectrum(std::uint32_t x, std::uint32_t y);

  /// The light of one pixel and of those around it.
  struct MeasuredLight {
    LightReading pixel, block;
    bool has_variance = false;  // the job has what errors are made of
    bool shares = false;        // pixels share samples: the block's error is an upper bound
  };
  /// Side of the block, whose pixels are those from 4 before to 3 behind.
  static constexpr std::uint32_t kMeterBlock = 8;
  /// The light about pixel (x, y) of the crop, read from the results again; of a picture of colours.
  /// InvalidArgument where the crop has no such pixel or the layer is no colour, ResourceExhausted where the
  /// pixels are made of too many results.
  absl::StatusOr<MeasuredLight> measure(std::uint32_t x, std::uint32_t y);

  /// Units of the job's colours; they are read once.
  PixelUnits units();

  /// The changes since a page was told, which may be everything.
  struct News {
    std::uint64_t generation = 0;  // the picture was begun anew so often
    std::uint64_t changes = 0;
    bool all = false;
    std::vector<PixelArea> areas;
  };
  News since(std::uint64_t generation, std::uint64_t changes) const;

  const PixelArea& area() const { return area_; }
  const std::string& job() const { return job_; }
  const PictureLayer& layer() const { return layer_; }

 private:
  struct Result {
    std::uint64_t sequence;
    PixelArea area;
  };
  struct Band {
    std::size_t channel;
    double centre_nm;
  };
  static std::vector<Band> bands_of(const JobShape& shape);

  absl::Status add(const v1::UnitResult& result, double cpu_seconds);
  void find_pilot();
  /// Whether results are remembered, to be read again.
  bool keeps_results() const { return picture_.level() > 0 || !bands_.empty() || layer_.is_color(); }
  /// Reads the results again that have pixels of the film, and gives them to `take`.
  template <class Take>
  absl::Status read_again(const PixelArea& film, Take&& take);
  absl::StatusOr<wire::TileResult> read(std::uint64_t sequence) const;

  FarmViews& views_;
  const std::string job_;
  const std::shared_ptr<const JobShape> shape_;
  const PixelArea area_;
  const PictureLayer layer_;
  const std::vector<Band> bands_;

  std::mutex following_;  // locked before mutex_
  std::uint64_t after_ = 0;

  mutable std::mutex mutex_;
  Picture picture_;
  std::shared_ptr<const wire::PilotBlocks> pilot_;  // written by who holds following_, too
  std::uint64_t generation_ = 1;
  std::uint32_t revision_ = 0;
  std::vector<Result> results_;  // where keeps_results()
  std::optional<PixelUnits> units_;
};

/// Pictures that are looked at, and a few that were. Thread-safe.
class Pictures {
 public:
  /// Pictures, and bytes of their planes, that are kept. One takes 64 MiB at most.
  static constexpr std::size_t kMost = 256, kMostBytes = std::size_t{1} << 30;

  explicit Pictures(FarmViews& views, std::size_t most_bytes = kMostBytes)
      : views_(views), most_bytes_(most_bytes) {}

  /// NotFound for a job or a layer that is not there; ResourceExhausted when there is no room, because all
  /// that is kept is looked at.
  absl::StatusOr<std::shared_ptr<ShownPicture>> open(const std::string& job, const std::string& layer);

  /// Likewise of the job's first layer, its colours.
  absl::StatusOr<std::shared_ptr<ShownPicture>> open_colors(const std::string& job);

 private:
  using Key = std::pair<std::string, std::string>;
  struct Kept {
    std::shared_ptr<ShownPicture> picture;
    std::uint64_t used = 0;
  };

  /// Drops what nobody looks at, the longest unused first, until there is room for so many bytes.
  bool make_room(std::size_t bytes);

  FarmViews& views_;
  const std::size_t most_bytes_;
  std::mutex mutex_;
  std::map<Key, Kept> kept_;
  std::uint64_t uses_ = 0;
};

}  // namespace tessera::server
