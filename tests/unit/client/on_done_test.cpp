// The user's command at the end of a job.
#include "command/jobs/on_done.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "command/exit_code.h"
#include "support/process/temp_dir.h"

namespace tessera::client {
namespace {

TEST(OnDone, TellsTheCommandOfTheJob) {
  const support::TempDir folder;
  const std::string file = (folder.path() / "told").string(), image = (folder.path() / "a b.exr").string();
  v1::JobStatus status;
  status.set_job_id("4f0c2a11");
  status.set_name("$(touch " + file + "-run) `id` ' \"");
  status.set_state(v1::FAILED);
  status.set_error("no; rm -rf");
  const OnDone told{
      "printf '%s\\n' \"$TESSERA_JOB\" \"$TESSERA_NAME\" \"$TESSERA_STATE\" \"$TESSERA_ERROR\" "
      "\"$TESSERA_OUTPUT\" >>" +
      file};
  EXPECT_EQ(told.run(status, image, kJobFailed), kJobFailed);
  std::ofstream(image) << "there";
  EXPECT_EQ(told.run(status, image, kDone), kDone);
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string lines = "4f0c2a11\n" + status.name() + "\nfailed\nno; rm -rf\n";
  EXPECT_EQ(text, lines + "\n" + lines + image + "\n");
  EXPECT_FALSE(std::filesystem::exists(file + "-run"));
}

TEST(OnDone, SaysWhenTheCommandFails) {
  v1::JobStatus status;
  EXPECT_EQ(OnDone{""}.run(status, "", kDone), kDone);
  EXPECT_EQ(OnDone{"exit 3"}.run(status, "", kDone), kIncomplete);
  EXPECT_EQ(OnDone{"exit 3"}.run(status, "", kHoles), kHoles);
  EXPECT_EQ(OnDone{"kill -9 $$"}.run(status, "", kDone), kIncomplete);
}

}  // namespace
}  // namespace tessera::client
