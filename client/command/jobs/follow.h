// Waits for a job and puts its image together.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "command/report/output.h"
#include "farm/farm_client.h"
#include "image/assemble.h"
#include "image/cryptomatte.h"
#include "image/exr/rows.h"
#include "image/image.h"
#include "wire/tile_result.h"

namespace tessera::client {

/// Whether an image of a job that is not over is wanted, and from when on.
struct PartialImage {
  bool wanted = false;  // also when following is stopped, or broken off, or the job was cancelled or failed
  // Following is over when so many units have come; 0: with the job.
  std::uint32_t units = 0;
};

/// The picture of one of the job's views.
struct FollowedImage {
  Image image;
  std::unique_ptr<Rows> rows;  // the image's pixels, where it has none itself
  std::uint64_t incomplete_pixels = 0;
  std::vector<Hole> holes;
  absl::Status denoised;  // why a whole image stays as it was rendered, where that was not asked for
  bool written = false;   // deliver() has written the image
};

struct FollowedJob {
  v1::JobStatus status;
  absl::Status broken_off;  // why following ended before the job did, where a partial image is wanted
  // One a view, when the job is done, or incomplete, or a partial one is wanted and there is something.
  std::vector<FollowedImage> images;
};

/// Settings of the program that follows.
struct FollowOptions {
  bool quiet = false;                   // no progress on stderr
  std::function<bool()> building = {};  // whether a worker of its own builds the scene
  // Bytes of a frame that may be kept in memory; a larger one has its pixels in FollowedImage::rows.
  std::uint64_t frame_memory = UINT64_MAX;  // the sum over all views
  std::vector<MatteList> mattes = {};       // the Cryptomattes that lists of identifiers become
  // Each result of view 0 as it comes, where somebody looks on; and that all of them come again, for some
  // were wrong.
  std::function<void(const wire::TileResult&)> show = {};
  std::function<void()> show_anew = {};
};

/// The part of the film that is rendered.
Window crop_of(const v1::JobSpec& spec);

/// Follows the job to its end, with progress on stderr, and what happens to it meanwhile. Errors: those of
/// JobCalls::watch; Internal when results do not fit the job.
absl::StatusOr<FollowedJob> follow_job(JobCalls& farm, const std::string& job_id, const v1::JobSpec& spec,
                                       const FollowOptions& options, std::stop_token stop,
                                       const PartialImage& partial = {});

/// The same without an image: progress, and what FollowOptions shows.
absl::StatusOr<v1::JobStatus> follow_progress(FarmClient& farm, const std::string& job_id,
                                              const v1::JobSpec& spec, const FollowOptions& how,
                                              std::stop_token stop);

/// The exit code of a job that has ended, with a message on stderr when that was not well: of an incomplete
/// one, kHoles and what is missing.
int report_end(const v1::JobStatus& status);

/// Bytes of a frame that may be kept in memory while it is on its way to its file: as `exr` has it, or else
/// what the machine can spare; any number where the picture is denoised, which takes so many bytes in all,
/// and these are free.
std::uint64_t frame_memory(const ExrFormat& exr, std::uint64_t denoising = 0);

/// The file of a view's picture: `output` for view 0, and for others one with the view's number before the
/// extension, "scene.v07.exr".
std::string output_of_view(const std::string& output, std::uint32_t view, std::uint32_t views);

/// Ends a command that followed a job: lists holes in the attribute "tessera.holes" of the images, says in
/// "tessera.partial" how much there is of one that is not whole, prints the job's warnings (unless quiet) and
/// its error, writes the images with their metadata to `output` (output_of_view), and returns the exit code.
int deliver(FollowedJob& followed, const v1::JobSpec& spec, const std::string& output, const ExrFormat& exr,
            bool quiet);

}  // namespace tessera::client
