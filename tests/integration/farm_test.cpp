// The farm in everyday use: uploads, late workers, cancelling.
#include <gtest/gtest.h>

#include <fstream>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

TEST(Farm, ASecondSubmitUploadsNothing) {
  FarmUnderTest farm;
  farm.add_worker(2);
  const auto uploaded = [&](const char* spp) {
    const std::filesystem::path stats = farm.directory() / "stats.json";
    const support::Finished done = tessera(farm.on_farm(
        {"submit", "--fresh", "scenes/cornell-box/scene.pbrt", "--resolution", "32x32", "--spp", spp,
         "--quiet", "-o", (farm.directory() / "image.exr").string(), "--stats", stats.string()}));
    EXPECT_EQ(done.status.code, 0) << done.err;
    EXPECT_EQ(json_number(stats, "samples"), 32 * 32 * std::stod(spp));
    return json_number(stats, "uploaded_bytes");
  };
  EXPECT_GT(uploaded("4"), 0);
  EXPECT_EQ(uploaded("8"), 0);
}

TEST(Farm, AWorkerThatComesLateTakesPart) {
  FarmUnderTest farm;
  const std::string job_id = farm.submit_detached(in_many_units("160", "256"));
  farm.add_worker(1);
  farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_done() > 0; });
  farm.add_worker(1);
  const v1::JobStatus end = farm.watch_until(job_id, [](const v1::JobStatus&) { return false; });
  EXPECT_EQ(end.state(), v1::DONE) << end.error();
  const auto workers = farm.client().workers({});
  ASSERT_TRUE(workers.ok()) << workers.status();
  ASSERT_EQ(workers->size(), 2U);
  for (const v1::WorkerStatus& worker : *workers) EXPECT_GT(worker.units_done(), 0U) << worker.name();
}

TEST(Farm, CancellingStopsTheWorkers) {
  FarmUnderTest farm;
  support::Process& worker = farm.add_worker(2);
  // Hours of work in units of minutes: they must be stopped in their midst.
  const std::string job_id = farm.submit_detached(
      {"scenes/cornell-box/scene.pbrt", "--resolution", "2048x2048", "--spp", "65536", "--tile", "1024"});
  farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_leased() >= 2; });
  ASSERT_TRUE(worker.wait_for_err("loaded in", kPatience)) << worker.err();

  const support::Finished cancelled = tessera(farm.on_farm({"cancel", job_id}));
  EXPECT_EQ(cancelled.status.code, 0) << cancelled.err;
  ASSERT_TRUE(worker.wait_for_err("leases revoked", kPatience)) << worker.err();

  // A worker that had not stopped could not render this.
  const support::Finished next =
      tessera(farm.on_farm({"submit", "scenes/cornell-box/scene.pbrt", "--resolution", "16x16", "--spp", "1",
                            "--quiet", "-o", (farm.directory() / "next.exr").string()}));
  EXPECT_EQ(next.status.code, 0) << next.err;
  EXPECT_EQ(tessera(farm.on_farm({"watch", job_id})).status.code, 5)
      << "the exit code of a job that was cancelled";
}

/// Whether the pixels behind an image's header can be decoded is seen by the worker; all else the client says
/// before anything is uploaded.
TEST(Farm, ASceneThatCannotBeBuiltFailsTheJob) {
  FarmUnderTest farm;
  farm.add_worker(1);
  const std::filesystem::path scene = farm.directory() / "bad.textproto",
                              image = farm.directory() / "bad.png";
  std::filesystem::copy_file("scenes/tiled-floor/tiles.png", image);
  std::filesystem::resize_file(image, std::filesystem::file_size(image) / 2);
  std::ofstream{scene} << "camera { perspective { fov_degrees: 40 } }\n"
                          "film { width: 8 height: 8 }\n"
                          "textures { name: 'tiles' image { image { path: 'bad.png' } } }\n"
                          "materials { name: 'floor' diffuse { reflectance { texture: 'tiles' } } }\n"
                          "shapes { material: 'floor' sphere { radius: 1 } }\n"
                          "lights { infinite { radiance { constant: 1 } } }\n";
  const support::Finished done =
      tessera(farm.on_farm({"submit", scene.string(), "-o", (farm.directory() / "bad.exr").string()}));
  EXPECT_EQ(done.status.code, 5) << done.err;
  EXPECT_NE(done.err.find("failed"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("bad.png"), std::string::npos) << done.err;
}

TEST(Farm, ANameThatRefersToNothingIsRefusedBeforeItIsUploaded) {
  FarmUnderTest farm;
  const std::filesystem::path scene = farm.directory() / "bad.textproto";
  std::ofstream{scene} << "camera { perspective { fov_degrees: 40 } }\n"
                          "film { width: 8 height: 8 }\n"
                          "materials { name: 'clay' diffuse {} }\n"
                          "shapes { name: 'lamp' material: 'clai' sphere { radius: 1 } }\n";
  const support::Finished done =
      tessera(farm.on_farm({"submit", scene.string(), "-o", (farm.directory() / "bad.exr").string()}));
  EXPECT_EQ(done.status.code, 3);
  EXPECT_NE(done.err.find("bad.textproto:4"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("did you mean \"clay\"?"), std::string::npos) << done.err;
}

}  // namespace
}  // namespace tessera::integration
