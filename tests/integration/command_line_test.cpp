// Exit codes and messages of the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "image/exr.h"
#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

using ::testing::HasSubstr;

const std::string kScene = "scenes/cornell-box/scene.pbrt";

TEST(CommandLine, AnUnknownIntegratorIsAUsageErrorThatNamesTheKnownOnes) {
  const support::Finished done = tessera({"render", kScene, "-o", "x.exr", "--integrator", "magic"});
  EXPECT_EQ(done.status.code, 2);
  EXPECT_THAT(done.err, HasSubstr("there is no integrator 'magic'; there is: path"));
}

TEST(CommandLine, ABiasedPictureSaysSo) {
  const support::TempDir directory;
  const std::string file = (directory.path() / "a.exr").string();
  const support::Finished done = tessera({"render", "scenes/first-light/scene.textproto", "-o", file, "--spp",
                                          "1", "--resolution", "32x18", "--integrator", "whitted"});
  ASSERT_EQ(done.status.code, 0) << done.err;
  const std::string warning = "warning: integrator 'whitted' is biased";
  const std::size_t first = done.err.find(warning);
  ASSERT_NE(first, std::string::npos) << done.err;
  EXPECT_EQ(done.err.find(warning, first + 1), std::string::npos) << done.err;
  const auto image = client::read_exr(file);
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(std::get<std::string>(image->metadata.at("tessera.integrator_kind")), "biased");
}

TEST(CommandLine, APictureThatCannotBeDenoisedIsWrittenRaw) {
  const support::TempDir directory;
  const std::string file = (directory.path() / "a.exr").string();
  ::setenv("TESSERA_OIDN", "/nowhere/liboidn.so", 1);
  const support::Finished done = tessera({"render", "scenes/first-light/scene.textproto", "-o", file, "--spp",
                                          "2", "--resolution", "32x18", "--denoise", "oidn"});
  ::unsetenv("TESSERA_OIDN");
  EXPECT_EQ(done.status.code, 10) << done.err;
  EXPECT_THAT(done.err, HasSubstr("a.exr is as it was rendered, not denoised: "));
  EXPECT_THAT(done.err, HasSubstr("/nowhere/liboidn.so"));
  const auto image = client::read_exr(file);
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_FALSE(image->metadata.contains("tessera.denoised"));
  const auto again = (directory.path() / "b.exr").string();
  EXPECT_EQ(tessera({"denoise", file, "-o", again}).status.code, 0) << "the file has all that it takes";
}

TEST(CommandLine, BenchComparesAllIntegratorsThatCanRenderAScene) {
  const support::TempDir directory;
  const auto bench = [&](const std::string& scene) {
    const support::Finished done =
        tessera({"bench", scene, "--compare", "integrator=all", "--resolution", "32x32", "--spp", "1",
                 "--seeds", "1", "--make-reference", "2", "--quiet"});
    EXPECT_EQ(done.status.code, 0) << done.err;
    return done.out;
  };
  const std::string surfaces = bench("scenes/first-light/scene.textproto");
  EXPECT_THAT(surfaces, HasSubstr("integrator=path, unbiased\n"));
  EXPECT_THAT(surfaces, HasSubstr("integrator=whitted, biased\n"));
  const std::string media = bench("tests/statistical/unbiased/scenes/media.textproto");
  EXPECT_THAT(media, HasSubstr("integrator=volpath, unbiased\n"));
  EXPECT_THAT(media, HasSubstr("not measured: integrator=path: sees no media\n"));
}

TEST(CommandLine, BenchComparesAllAccelerators) {
  const support::Finished done =
      tessera({"bench", "scenes/first-light/scene.textproto", "--compare", "accelerator=all", "--resolution",
               "16x16", "--spp", "1", "--seeds", "1", "--make-reference", "2", "--quiet"});
  EXPECT_EQ(done.status.code, 0) << done.err;
  for (const char* name : {"embree", "brute", "bvh-sah", "sphere-tree", "kd-median"})
    EXPECT_THAT(done.out, HasSubstr(absl::StrCat("accelerator=", name, ", unbiased\n")));
  EXPECT_THAT(done.out, HasSubstr("references a primitive"));
}

TEST(CommandLine, ValuesThatMakeNoSenseAreUsageErrors) {
  const std::vector<std::vector<std::string>> wrong{{"--spp", "0"},          {"--spp", "-4"},
                                                    {"--resolution", "640"}, {"--resolution", "0x480"},
                                                    {"--crop", "5,5,5,9"},   {"--crop", "1,2,3"},
                                                    {"--tile", "0"},         {"--threads", "0"},
                                                    {"--sampler", "dice"},   {"--aov", "beauty"},
                                                    {"--isa", "z80"},        {"-D", "noequals"},
                                                    {"--no-such-option"},    {"--crop", "0,0,100000,100000"}};
  for (const std::vector<std::string>& options : wrong) {
    std::vector<std::string> arguments{"render", kScene, "-o", "x.exr"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const support::Finished done = tessera(arguments);
    EXPECT_EQ(done.status.code, 2) << options[0] << ": " << done.err;
    EXPECT_FALSE(done.err.empty());
  }
}

TEST(CommandLine, AnOutputThatCannotBeWrittenIsNoticedFirst) {
  EXPECT_EQ(tessera({"render", kScene, "-o", "x.jpg"}).status.code, 2);
  EXPECT_EQ(tessera({"render", kScene, "-o", "/no/such/directory/x.exr"}).status.code, 2);
  EXPECT_EQ(tessera({"render", kScene}).status.code, 2);
}

TEST(CommandLine, ABadSceneIsNamed) {
  const support::TempDir directory;
  const std::string scene = (directory.path() / "bad.pbrt").string();
  std::ofstream{scene} << "WorldBegin\nNoSuchDirective\n";
  const support::Finished done = tessera({"render", scene, "-o", "x.exr"});
  EXPECT_EQ(done.status.code, 3);
  EXPECT_THAT(done.err, HasSubstr("bad.pbrt:2:1"));
}

TEST(CommandLine, ACoordinatorThatIsNotThereIsNamed) {
  for (const char* command : {"jobs", "workers"}) {
    // Nothing listens on port 1: it is reserved.
    const support::Finished done = tessera({command, "--server", "127.0.0.1:1"});
    EXPECT_EQ(done.status.code, 4) << command;
    EXPECT_THAT(done.err, HasSubstr("127.0.0.1:1"));
  }
  EXPECT_EQ(tessera({"jobs", "--server", "nonsense"}).status.code, 2);
}

TEST(CommandLine, AJobThatDoesNotExistIsNamed) {
  const FarmUnderTest farm;
  for (const char* command : {"job", "watch", "cancel"}) {
    const support::Finished done = tessera(farm.on_farm({command, "nobody"}));
    EXPECT_EQ(done.status.code, 2) << command;
    EXPECT_THAT(done.err, HasSubstr("nobody"));
  }
}

TEST(CommandLine, BenchMeasuresComparesAndKeepsItsReference) {
  const support::TempDir directory;
  const std::string reference = (directory.path() / "ref.exr").string(),
                    json = (directory.path() / "bench.json").string(),
                    plot = (directory.path() / "bench.svg").string();
  const support::Finished made =
      tessera({"bench", kScene, "--resolution", "32x32", "--make-reference", "64", "--reference", reference,
               "--spp", "1,4", "--seeds", "2", "--compare", "sampler=sobol,independent", "--json", json,
               "--plot", plot, "--quiet"});
  ASSERT_EQ(made.status.code, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("efficiency of sampler=independent over sampler=sobol"));
  EXPECT_TRUE(std::filesystem::exists(plot));
  EXPECT_EQ(json_number(json, "seeds"), 2);

  const support::Finished kept = tessera({"bench", kScene, "--resolution", "32x32", "--reference", reference,
                                          "--spp", "4", "--seeds", "1", "--quiet"});
  ASSERT_EQ(kept.status.code, 0) << kept.err;
  EXPECT_THAT(kept.out, HasSubstr("its own MSE")) << "the noise is known from the file";

  // Whole processes of this program and a peer, which is this program too: the same pictures.
  const std::string later = (directory.path() / "later.json").string();
  const std::string peer = absl::StrCat(
      tessera_program(),
      " render {scene} --spp {spp} --seed 7 --resolution 32x32 --max-depth 3 --threads 1 -o {out}");
  const support::Finished whole = tessera(
      {"bench",   kScene,      "--resolution", "32x32",   "--reference", reference, "--spp",   "1,4",
       "--seeds", "2",         "--max-depth",  "3",       "--seed",      "7",       "--whole", "--json",
       later,     "--against", json,           "--quiet", "--peer",      peer});
  ASSERT_EQ(whole.status.code, 0) << whole.err;
  EXPECT_THAT(whole.out, HasSubstr("efficiency of tessera over peer "));
  EXPECT_THAT(whole.out, HasSubstr("machine: "));
  EXPECT_THAT(whole.out, HasSubstr("not measured then with these settings"));
  std::ifstream file(later);
  const auto scene = nlohmann::json::parse(file)["scenes"][0];
  // In this process and in another, with the options and the seeds that were given.
  for (std::size_t run = 0; run < 4; ++run) {
    EXPECT_NEAR(scene["whole"][0]["runs"][run]["relmse_trimmed"].get<double>(),
                scene["variants"][0]["runs"][run]["relmse_trimmed"].get<double>(), 1e-12);
  }
  EXPECT_EQ(scene["whole"][1]["runs"][0]["relmse"], scene["whole"][0]["runs"][0]["relmse"]) << "seed 7";
  const support::Finished lacking =
      tessera({"bench", kScene, "--reference", reference, "--peer", "render {scene} {spp}"});
  EXPECT_EQ(lacking.status.code, 2);
  EXPECT_THAT(lacking.err, HasSubstr("lacks {out}"));

  const support::Finished other =
      tessera({"bench", kScene, "--resolution", "32x48", "--reference", reference, "--spp", "1"});
  EXPECT_EQ(other.status.code, 2);
  EXPECT_THAT(other.err, HasSubstr("32x32"));
  EXPECT_THAT(other.err, HasSubstr("32x48"));
}

TEST(CommandLine, BenchRefusesWhatMakesNoSense) {
  const std::vector<std::vector<std::string>> wrong{
      {},
      {"--reference", "no-such-file.exr"},
      {"--reference", "a.exr,b.exr"},
      {"--make-reference", "1"},
      {"--make-reference", "8", "--spp", "0"},
      {"--make-reference", "8", "--seeds", "0"},
      {"--make-reference", "8", "--plot", "plot.pdf"},
      {"--make-reference", "8", "--compare", "sampler"},
      {"--make-reference", "8", "--compare", "sampler=sobol"},
      {"--make-reference", "8", "--compare", "no-such=a,b"},
      {"--make-reference", "8", "--compare", "sampler=dice,sobol"}};
  for (const std::vector<std::string>& options : wrong) {
    std::vector<std::string> arguments{"bench", kScene, "--resolution", "16x16", "--quiet"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const support::Finished done = tessera(arguments);
    EXPECT_EQ(done.status.code, 2) << testing::PrintToString(options) << ": " << done.err;
    EXPECT_FALSE(done.err.empty());
  }
}

TEST(CommandLine, ARenderedImageComparesEqualToItselfAndConverts) {
  const support::TempDir directory;
  const std::string image = (directory.path() / "image.exr").string();
  const std::string stats = (directory.path() / "stats.json").string();
  const support::Finished rendered = tessera(
      {"render", kScene, "--resolution", "32x32", "--spp", "4", "-o", image, "--stats", stats, "--quiet"});
  ASSERT_EQ(rendered.status.code, 0) << rendered.err;
  EXPECT_EQ(rendered.out + rendered.err, "") << "--quiet is silent";
  EXPECT_EQ(json_number(stats, "samples"), 32 * 32 * 4);
  EXPECT_EQ(json_number(stats, "spp"), 4);
  for (const char* name : {"load_seconds", "build_seconds", "render_wall_seconds", "render_cpu_seconds"}) {
    EXPECT_GE(json_number(stats, name), 0) << name;
  }
  EXPECT_GT(json_number(stats, "peak_memory_bytes"), 0);

  const support::Finished compared = tessera({"compare", image, image, "--json"});
  EXPECT_EQ(compared.status.code, 0) << compared.err;
  EXPECT_THAT(compared.out, HasSubstr("\"relmse\""));
  const std::string preview = (directory.path() / "image.png").string();
  EXPECT_EQ(tessera({"convert", image, preview}).status.code, 0);
  EXPECT_TRUE(std::filesystem::exists(preview));
  for (const char* name : {"luminance.png", "luminance.exr"}) {
    const std::string map = (directory.path() / name).string();
    const support::Finished done = tessera({"convert", image, map, "--false-color", "--scale", "log",
                                            "--range", "0.1,1000", "--isolines", "--cd-per-m2", "179"});
    EXPECT_EQ(done.status.code, 0) << done.err;
    EXPECT_TRUE(std::filesystem::exists(map));
  }
  using Options = std::vector<std::string>;
  for (const Options& wrong : {Options{"--isolines"},
                               {"--false-color", "--range", "3,1"},
                               {"--false-color", "--range", "1"},
                               {"--false-color", "--scale", "log", "--range", "0,1"},
                               {"--false-color", "--color-map", "rainbow"},
                               {"--false-color", "--exposure", "1"},
                               {"--false-color", "--cd-per-m2", "0"}}) {
    Options arguments{"convert", image, preview};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    EXPECT_EQ(tessera(arguments).status.code, 2) << testing::PrintToString(wrong);
  }
  EXPECT_EQ(
      tessera({"convert", kScene, (directory.path() / "own.tsb").string(), "--false-color"}).status.code, 2);
}

TEST(CommandLine, ASceneInTesserasOwnFormGivesTheSameBits) {
  const support::TempDir directory;
  const std::string from_pbrt = (directory.path() / "pbrt.exr").string();
  ASSERT_EQ(tessera({"render", kScene, "--resolution", "32x32", "--spp", "4", "-o", from_pbrt, "--quiet"})
                .status.code,
            0);
  for (const char* form : {"own.textproto", "own.tsb"}) {
    const std::string own = (directory.path() / form).string();
    ASSERT_EQ(tessera({"convert", kScene, own, "--quiet"}).status.code, 0) << form;
    const std::string from_own = (directory.path() / "own.exr").string();
    ASSERT_EQ(tessera({"render", own, "--resolution", "32x32", "--spp", "4", "-o", from_own, "--quiet"})
                  .status.code,
              0);
    EXPECT_EQ(pixel_sha256(from_own), pixel_sha256(from_pbrt)) << form;
  }
}

}  // namespace
}  // namespace tessera::integration
