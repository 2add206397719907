// Frames of an animation: lists, orders, names of files, and what becomes of those that fail.
#include "command/frames/frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "command/exit_code.h"
#include "image/exr.h"
#include "unit/client/files.h"

namespace tessera::client::frames_of_animations {
namespace {

using testing::DoubleNear;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsNan;

TEST(Frames, ListsAreRangesStepsAndNumbers) {
  const auto list = [](std::string_view text) {
    const auto frames = parse_frames(text);
    return frames.ok() ? *frames : std::vector<std::int64_t>{};
  };
  EXPECT_THAT(list("7"), ElementsAre(7));
  EXPECT_THAT(list("1-4"), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(list("1-8x3,200,2"), ElementsAre(1, 4, 7, 200, 2));
  EXPECT_THAT(list("1-3,2-4"), ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(list("0-1048575").size(), std::size_t{1} << 20);
  for (const char* wrong : {"", "a", "1-", "-1", "4-1", "1-9x0", "1,,2", "1-9x", "1 2", "0-1048576",
                            "1-999999999", "9999999999", "99999999999999999999"}) {
    EXPECT_THAT(list(wrong), IsEmpty()) << wrong;
    EXPECT_EQ(parse_frames(wrong).status().code(), absl::StatusCode::kInvalidArgument) << wrong;
  }
}

TEST(Frames, OrdersTakeEachFrameOnce) {
  const std::vector<std::int64_t> nine = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_EQ(in_order(nine, FrameOrder::kForward), nine);
  EXPECT_THAT(in_order({3, 1, 2}, FrameOrder::kReverse), ElementsAre(2, 1, 3));
  EXPECT_THAT(in_order(nine, FrameOrder::kBinary), ElementsAre(1, 9, 5, 3, 7, 2, 4, 6, 8));
  EXPECT_THAT(in_order({4, 8}, FrameOrder::kBinary), ElementsAre(4, 8));
  const std::vector<std::int64_t> many = *parse_frames("1-100");
  const std::vector<std::int64_t> shuffled = in_order(many, FrameOrder::kBinary);
  EXPECT_EQ(std::set(shuffled.begin(), shuffled.end()), std::set(many.begin(), many.end()));
  EXPECT_EQ(shuffled.size(), many.size());
}

TEST(Frames, NamesHaveThePlaceOfTheNumberInTheFileAlone) {
  EXPECT_EQ(path_of_frame("a/name.####.exr", 7), "a/name.0007.exr");
  EXPECT_EQ(path_of_frame("name#.exr", 12345), "name12345.exr");
  EXPECT_EQ(path_of_frame("#1/name.exr", 7), "#1/name.exr");
  EXPECT_FALSE(has_frame_mark("#1/name.exr"));
  EXPECT_TRUE(has_frame_mark("name.#.exr"));
  EXPECT_EQ(text_of_frame("angle={frame}", 30), "angle=30");
}

TEST(Frames, OneFrameHasItsOwnFilesAndParameters) {
  RenderOptions all;
  all.scene = "s.##.pbrt", all.output = "o.##.exr", all.stats = "t.##.json", all.checkpoint = "kept";
  all.defines = {"angle={frame}"};
  const RenderOptions one = options_of_frame(all, 5);
  EXPECT_EQ(one.scene, "s.05.pbrt");
  EXPECT_EQ(one.output, "o.05.exr");
  EXPECT_EQ(one.stats, "t.05.json");
  EXPECT_EQ(one.checkpoint, "kept/5");
  EXPECT_THAT(one.defines, ElementsAre("angle=5"));
  EXPECT_EQ(one.frame, 5);
}

TEST(Frames, ImagesThatWouldReplaceEachOtherAreRefused) {
  RenderOptions options;
  options.output = "a.exr";
  options.frames.frames = {1, 2};
  EXPECT_THAT(std::string(check_frames(options).message()), HasSubstr("name.####.exr"));
  options.frames.frames = {1};
  EXPECT_TRUE(check_frames(options).ok());
  options.frames.preview_video = "a.avi";
  EXPECT_THAT(std::string(check_frames(options).message()), HasSubstr(".mp4"));
}

/// Frames that end with these exit codes; 0 for those that are not named.
struct Farm {
  std::map<std::int64_t, int> codes;
  std::vector<std::int64_t> started = {};
  std::vector<double> origins = {};  // x; NaN: none
  std::size_t open = 0, most_open = 0;

  StartFrame start() {
    return [this](const RenderOptions& frame, int&) -> FrameJob {
      started.push_back(*frame.frame);
      origins.push_back(frame.origin && *frame.origin ? (*frame.origin)->x() : NAN);
      most_open = std::max(most_open, ++open);
      return [this, number = *frame.frame] {
        --open;
        return codes.contains(number) ? codes.at(number) : 0;
      };
    };
  }
};

RenderOptions animation(const std::string& output, const char* list) {
  RenderOptions options;
  options.output = output;
  options.quiet = true;
  options.frames.frames = *parse_frames(list);
  return options;
}

TEST(Frames, ThoseThatFailKeepNoOtherFromBeingRendered) {
  Farm farm{.codes = {{2, kJobFailed}, {4, kIncomplete}}};
  testing::internal::CaptureStderr();
  const int code = run_frames(animation("a.####.exr", "1-5"), 2, farm.start(), {});
  EXPECT_EQ(code, kFramesFailed);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("frames without a whole image: 2,4"));
  EXPECT_THAT(farm.started, ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(farm.most_open, 2u);
  EXPECT_EQ(farm.open, 0u);
}

TEST(Frames, ThoseThatAreNotDenoisedAreListed) {
  Farm farm{.codes = {{2, kNotDenoised}}};
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_frames(animation("a.####.exr", "1-3"), 2, farm.start(), {}), kNotDenoised);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("frames that are not denoised: 2\n"));
  farm.codes[3] = kIncomplete;
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_frames(animation("a.####.exr", "1-3"), 2, farm.start(), {}), kFramesFailed);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("frames without a whole image: 3\n"));
}

TEST(Frames, WithoutACoordinatorThereIsNoUseInGoingOn) {
  Farm farm{.codes = {{2, kUnreachable}}};
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_frames(animation("a.####.exr", "1-50"), 1, farm.start(), {}), kUnreachable);
  static_cast<void>(testing::internal::GetCapturedStderr());
  EXPECT_THAT(farm.started, ElementsAre(1, 2));
}

TEST(Frames, AreCountedByWhatWasDoneWithThem) {
  Farm farm;
  RenderOptions options = animation("a.####.exr", "1-3");
  options.quiet = false;
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_frames(options, 2, farm.start(), {}, "submitted"), kDone);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("3 frames submitted, 0 were there, 0 failed\n"));
}

/// The words by which a program of the test, in place of ffmpeg, is called for a film of the scene's frames 1
/// and 2.
std::string call_of_ffmpeg(const support::TempDir& directory, RenderOptions options) {
  const std::string program = directory / "ffmpeg", path = std::getenv("PATH");
  write_bytes(program, absl::StrCat("#!/bin/sh\necho \"$@\" > ", directory / "call", "\n"));
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  setenv("PATH", absl::StrCat(directory.path().string(), ":", path).c_str(), 1);
  options.scene = directory / "scene.textproto";
  options.frames.preview_video = directory / "film.mp4";
  write_bytes(options.scene,
              "animation { frames_per_second: 30 }\nfilm { width: 4 height: 4 }\ncamera { perspective { "
              "fov_degrees: 40 } "
              "}\n"
              "shapes { sphere { radius: 1 } }\n");
  const StartFrame start = [](const RenderOptions& frame, int& exit_code) -> FrameJob {
    if (load_job(frame, exit_code) == nullptr) return nullptr;
    write_bytes(frame.output, "a picture");
    return [] { return kDone; };
  };
  EXPECT_EQ(run_frames(options, 1, start, {}), kDone);
  setenv("PATH", path.c_str(), 1);
  return read_bytes(directory / "call");
}

TEST(Frames, AFilmHasTheRateThatIsAskedForOrTheScenes) {
  const support::TempDir directory;
  RenderOptions options = animation(directory / "a.#.png", "1-2");
  EXPECT_THAT(call_of_ffmpeg(directory, options), HasSubstr("-framerate 30/1 "));
  options.frames.skip_existing = true;  // all are there, and no scene is loaded
  EXPECT_THAT(call_of_ffmpeg(directory, options), HasSubstr("-framerate 30/1 "));
  options.frames.rate = Rational{12, 1};
  EXPECT_THAT(call_of_ffmpeg(directory, options), HasSubstr("-framerate 12/1 "));
}

TEST(Frames, ImagesThatAreThereAreLeftOutUnlessTheyArePartial) {
  const support::TempDir directory;
  Image image;
  image.data = image.display = {0, 0, 2, 2};
  image.add("R");
  ASSERT_TRUE(write_exr(image, directory / "a.0001.exr").ok());
  image.metadata["tessera.partial"] = std::string("3 of 4 units");
  ASSERT_TRUE(write_exr(image, directory / "a.0002.exr").ok());
  write_bytes(directory / "a.0003.exr", "cut off");
  RenderOptions options = animation(directory / "a.####.exr", "1-4");
  options.frames.skip_existing = true;
  Farm farm;
  EXPECT_EQ(run_frames(options, 1, farm.start(), {}), kDone);
  EXPECT_THAT(farm.started, ElementsAre(2, 3, 4));
}

TEST(Frames, FilesOfTheirOwnAreMeasuredFromTheFirstCamera) {
  const support::TempDir directory;
  for (const int frame : {1, 2, 3}) {
    write_bytes(directory / absl::StrCat("turn.", frame, ".pbrt"),
                absl::StrCat("LookAt ", 3 * frame, " 1 5  0 0 0  0 1 0\nCamera \"perspective\"\n",
                             "WorldBegin\nShape \"sphere\"\n"));
  }
  RenderOptions options = animation(directory / "a.#.exr", "2,3,1");
  options.scene = directory / "turn.#.pbrt";
  options.frames.order = FrameOrder::kReverse;
  Farm files, one_file;
  EXPECT_EQ(run_frames(options, 1, files.start(), {}), kDone);
  EXPECT_THAT(files.started, ElementsAre(1, 3, 2));
  EXPECT_THAT(files.origins, Each(DoubleNear(6, 1e-6)));
  options.scene = directory / "turn.1.pbrt";
  EXPECT_EQ(run_frames(options, 1, one_file.start(), {}), kDone);
  EXPECT_THAT(one_file.origins, Each(IsNan()));
}

TEST(Frames, TheFirstFileIsReadOnce) {
  const support::TempDir directory;
  RenderOptions options = animation(directory / "a.#.exr", "1-3");
  options.scene = directory / "turn.#.pbrt";
  for (const int frame : {1, 2, 3}) {
    write_bytes(directory / absl::StrCat("turn.", frame, ".pbrt"),
                absl::StrCat("LookAt ", 3 * frame, " 1 5  0 0 0  0 1 0\nCamera \"perspective\"\n",
                             "WorldBegin\nShape \"sphere\"\n"));
  }
  std::vector<double> origins;
  const StartFrame start = [&](const RenderOptions& frame, int& exit_code) -> FrameJob {
    const std::unique_ptr<LoadedJob> loaded = load_job(frame, exit_code);
    if (loaded == nullptr) return nullptr;
    origins.push_back(loaded->imported.scene.render_origin().x());
    std::filesystem::remove(frame.scene);  // nobody can read it again
    return [] { return kDone; };
  };
  EXPECT_EQ(run_frames(options, 1, start, {}), kDone);
  EXPECT_THAT(origins, ElementsAre(DoubleNear(3, 1e-6), DoubleNear(3, 1e-6), DoubleNear(3, 1e-6)));
}

}  // namespace
}  // namespace tessera::client::frames_of_animations
