#include "command/frames/frames.h"

#include <algorithm>
#include <charconv>
#include <deque>
#include <filesystem>
#include <iostream>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "command/exit_code.h"
#include "command/frames/preview_video.h"
#include "command/read_option.h"
#include "image/exr.h"
#include "import/import.h"
#include "wire/scene_views.h"

namespace tessera::client {
namespace {

absl::StatusOr<Rational> parse_rate(std::string_view text) {
  const std::size_t slash = text.find('/');
  Rational rate;
  const auto read = [](std::string_view part, auto& number) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    return error == std::errc{} && end == part.data() + part.size() && number > 0;
  };
  const bool sound = read(text.substr(0, slash), rate.numerator) &&
                     (slash == std::string_view::npos || read(text.substr(slash + 1), rate.denominator));
  if (sound) return rate;
  return absl::InvalidArgumentError("expected frames a second, as in 24 or 30000/1001");
}

/// Whether the frame's picture is there, and whole.
bool is_there(const RenderOptions& frame) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(frame.output, error)) return false;
  if (!is_exr(frame.output)) return std::filesystem::file_size(frame.output, error) > 0;
  const absl::StatusOr<Image> facts = read_exr_facts(frame.output);
  return facts.ok() && !facts->metadata.contains("tessera.partial");
}

struct Frame {
  std::int64_t number = 0;
  FrameJob job;
};

std::string list_of_frames(std::vector<std::int64_t> frames) {
  std::ranges::sort(frames);
  return absl::StrJoin(frames, ",");
}

/// Where coordinates of all frames are measured from, if they are files of their own: those that differ by
/// their camera have one content then, and workers keep what they have built of it. It is where the camera of
/// the first one stands, whatever order they are rendered in.
class SharedOrigin {
 public:
  explicit SharedOrigin(const RenderOptions& all) : all_(all) {
    const bool are_files =
        has_frame_mark(all.scene) || std::ranges::any_of(all.defines, [](const std::string& define) {
          return text_of_frame(define, 0) != text_of_frame(define, 1);
        });
    if (are_files && all.frames.frames.size() > 1) place_ = std::make_shared<std::optional<v1::Point3>>();
  }

  /// For a frame that is about to be loaded. The first one finds the place when it is; before any other, its
  /// file is read for that.
  std::shared_ptr<std::optional<v1::Point3>> before(std::int64_t frame) {
    const std::int64_t first_frame = all_.frames.frames.front();
    if (!place_ || *place_ || frame == first_frame) return place_;
    const RenderOptions first = options_of_frame(all_, first_frame);
    const absl::StatusOr<ImportedScene> imported = import_scene(first.scene, import_options(first));
    if (imported.ok()) *place_ = wire::camera_place(imported->scene);
    if (!imported.ok()) place_ = nullptr;  // the frame says so itself, and the others do without
    return place_;
  }

 private:
  const RenderOptions& all_;
  std::shared_ptr<std::optional<v1::Point3>> place_;
};

/// Frames that have been finished, by how that went.
struct Ends {
  std::size_t done = 0;
  std::vector<std::int64_t> failed, raw;  // without a whole image; not denoised
  int last_failure_code = kDone;

  void note(std::int64_t frame, int exit_code) {
    if (exit_code == kDone) {
      ++done;
    } else if (exit_code == kNotDenoised) {
      raw.push_back(frame);
    } else {
      failed.push_back(frame);
      last_failure_code = exit_code;
    }
  }
};

/// Whether there is no use in going on.
bool ends_all(int exit_code) {
  return exit_code == kUsage || exit_code == kUnreachable || exit_code == kInterrupted;
}

}  // namespace

void define_frame_options(options::Command& command, RenderOptions& options) {
  command.group("Animation");
  FrameOptions& frames = options.frames;
  const auto take = [&frames](const std::string& text) {
    auto parsed = parse_frames(text);
    if (parsed.ok()) frames.frames = *std::move(parsed);
    return parsed.status();
  };
  const options::Option list =
      command
          .add_read_by("--frames", take,
                       "an image a frame: 1-100x2,200; #### in names of files is its number")
          .type_name("LIST");
  const WordList<FrameOrder> orders = {
      {"forward", FrameOrder::kForward}, {"reverse", FrameOrder::kReverse}, {"binary", FrameOrder::kBinary}};
  add_choice(command, "--frame-order", orders, frames.order,
             "forward, reverse, or binary: the first, the last, the middle, and so on")
      .needs(list)
      .as_setting();
  command.add_flag("--skip-existing", frames.skip_existing, "leave out frames whose image is there")
      .needs(list);
  const auto take_rate = [&frames](const std::string& text) {
    const auto rate = parse_rate(text);
    if (rate.ok()) frames.rate = *rate;
    return rate.status();
  };
  command.add_read_by("--fps", take_rate, "frames a second, also 30000/1001 (default: the scene's, or 24)")
      .type_name("RATE")
      .needs(list)
      .as_setting();
  command.add("--preview-video", frames.preview_video, "a film of all frames by ffmpeg: .mp4 or .gif")
      .type_name("FILE")
      .needs(list)
      .as_setting();
}

absl::Status check_frames(const RenderOptions& options) {
  const FrameOptions& frames = options.frames;
  const auto no = [](const std::string& what) { return absl::InvalidArgumentError(what); };
  if (!options.output.empty() && frames.frames.size() > 1 && !has_frame_mark(options.output))
    return no("--output needs a place for the frame's number, as in name.####.exr");
  if (!options.stats.empty() && frames.frames.size() > 1 && !has_frame_mark(options.stats))
    return no("--stats needs a place for the frame's number, as in stats.####.json");
  if (frames.skip_existing && options.output.empty()) return no("--skip-existing needs --output");
  return check_preview_video(options);
}

RenderOptions options_of_frame(const RenderOptions& all, std::int64_t frame) {
  RenderOptions one = all;
  one.frame = frame;
  one.scene = path_of_frame(all.scene, frame);
  one.output = path_of_frame(all.output, frame);
  one.stats = path_of_frame(all.stats, frame);
  for (std::string& define : one.defines) define = text_of_frame(define, frame);
  const Rational rate = all.frames.rate.value_or(Rational{});
  one.gltf.time = all.gltf.time.value_or(0) + static_cast<double>(frame) * rate.denominator / rate.numerator;
  if (!all.checkpoint.empty()) one.checkpoint = absl::StrCat(all.checkpoint, "/", frame);
  return one;
}

int run_frames(const RenderOptions& asked, std::size_t ahead, const StartFrame& start, std::stop_token stop,
               const char* deed) {
  RenderOptions options = asked;
  options.frames.scene_rate = std::make_shared<std::optional<Rational>>();
  SharedOrigin origin(options);
  Ends ends;
  std::size_t skipped = 0;
  std::deque<Frame> started;
  const auto finish_first = [&] {
    const Frame frame = std::move(started.front());
    started.pop_front();
    ends.note(frame.number, frame.job());
  };
  for (const std::int64_t number : in_order(options.frames.frames, options.frames.order)) {
    if (stop.stop_requested() || ends_all(ends.last_failure_code)) break;
    RenderOptions frame = options_of_frame(options, number);
    if (options.frames.skip_existing && is_there(frame)) {
      ++skipped;
      continue;
    }
    if (!options.quiet) std::cerr << "frame " << number << std::endl;
    frame.origin = origin.before(number);
    int exit_code = kDone;
    FrameJob job = start(frame, exit_code);
    if (job) {
      started.push_back({number, std::move(job)});
    } else {
      ends.note(number, exit_code);
    }
    while (started.size() >= ahead) finish_first();
  }
  while (!started.empty()) finish_first();
  if (!options.quiet) {
    std::cerr << ends.done + ends.raw.size() << " frames " << deed << ", " << skipped << " were there, "
              << ends.failed.size() << " failed\n";
  }
  if (stop.stop_requested()) return kInterrupted;
  if (!ends.failed.empty()) {
    const std::string text = absl::StrCat("frames without a whole image: ", list_of_frames(ends.failed));
    return report(
        ends_all(ends.last_failure_code) ? static_cast<ExitCode>(ends.last_failure_code) : kFramesFailed,
        text);
  }
  if (!ends.raw.empty())
    return report(kNotDenoised, "frames that are not denoised: " + list_of_frames(ends.raw));
  return options.frames.preview_video.empty() ? kDone : write_preview_video(options, stop);
}

}  // namespace tessera::client
