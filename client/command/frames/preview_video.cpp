#include "command/frames/preview_video.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "bench/process.h"
#include "command/exit_code.h"
#include "command/frames/frame_list.h"
#include "image/exr.h"
#include "image/png.h"
#include "import/import.h"

namespace tessera::client {
namespace fs = std::filesystem;
namespace {

/// A folder that goes away again.
class ScratchFolder {
 public:
  ScratchFolder() : path_(fs::temp_directory_path() / absl::StrCat("tessera-video-", ::getpid())) {
    std::error_code error;
    fs::create_directories(path_, error);
  }
  ~ScratchFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

bool is_gif(const std::string& path) { return fs::path(path).extension() == ".gif"; }

absl::Status put_frame(const std::string& image_path, const std::string& png) {
  if (!is_exr(image_path)) {
    std::error_code error;
    fs::copy_file(image_path, png, error);
    return error ? absl::InternalError(absl::StrCat(image_path, ": ", error.message())) : absl::OkStatus();
  }
  const absl::StatusOr<Image> image = read_exr(image_path);
  return image.ok() ? write_png(*image, png) : image.status();
}

/// Frames a second. Where all frames were there, and no scene has been read, one is read for that.
Rational rate_of(const RenderOptions& options) {
  if (options.frames.rate) return *options.frames.rate;
  if (options.frames.scene_rate && *options.frames.scene_rate) return **options.frames.scene_rate;
  const std::string scene = path_of_frame(options.scene, options.frames.frames.front());
  const absl::StatusOr<ImportedScene> imported = import_scene(scene, import_options(options));
  return frame_rate(options, imported.ok() ? imported->scene : v1::Scene{});
}

}  // namespace

absl::Status check_preview_video(const RenderOptions& options) {
  const std::string& video = options.frames.preview_video;
  if (video.empty()) return absl::OkStatus();
  const std::string extension = fs::path(video).extension().string();
  if (extension != ".mp4" && extension != ".gif")
    return absl::InvalidArgumentError(absl::StrCat("'", video, "' ends neither in .mp4 nor in .gif"));
  if (options.output.empty()) return absl::InvalidArgumentError("--preview-video needs --output");
  if (!run_process({"ffmpeg", "-version"}, {}).ok())
    return absl::InvalidArgumentError("--preview-video needs ffmpeg, which cannot be run here");
  return check_writable(video);
}

int write_preview_video(const RenderOptions& options, std::stop_token stop) {
  const ScratchFolder folder;
  std::vector<std::int64_t> frames = options.frames.frames;
  std::ranges::sort(frames);
  std::size_t number = 0;
  for (const std::int64_t frame : frames) {
    const std::string png = (folder.path() / absl::StrFormat("%07u.png", number++)).string();
    if (const absl::Status status = put_frame(path_of_frame(options.output, frame), png); !status.ok())
      return report(kIncomplete, absl::StrCat("no film was made: ", std::string(status.message())));
  }
  const Rational rate = rate_of(options);
  const std::string& video = options.frames.preview_video;
  // H.264 as players have it wants even sides; a GIF a palette of its own.
  const char* const filter = is_gif(video) ? "split[a][b];[a]palettegen[p];[b][p]paletteuse"
                                           : "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p";
  const auto made = run_process({"ffmpeg", "-y", "-loglevel", "error", "-framerate",
                                 absl::StrCat(rate.numerator, "/", rate.denominator), "-i",
                                 (folder.path() / "%07d.png").string(), "-vf", filter, video},
                                stop);
  return made.ok()
             ? kDone
             : report(kIncomplete, absl::StrCat("no film was made: ", std::string(made.status().message())));
}

}  // namespace tessera::client
