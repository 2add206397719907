#include "wire/enum_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "tessera/v1/camera.pb.h"
#include "tessera/v1/job.pb.h"
#include "wire/job_check.h"

namespace tessera::wire {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(EnumWords, AreTheNamesOfValuesWithoutThatOfTheEnum) {
  EXPECT_EQ(word_of(v1::SAMPLER_SOBOL), "sobol");
  EXPECT_EQ(word_of(v1::INCOMPLETE), "incomplete");
  EXPECT_THAT(words_of(*v1::LightSelection_descriptor()),
              ElementsAre("auto", "tree", "mixed", "power", "uniform"));
  EXPECT_EQ(word_of(v1::ACCELERATOR_KD_SAH), "kd-sah");
  EXPECT_THAT(words_of(*v1::PixelFilter::Kind_descriptor()),
              ElementsAre("box", "triangle", "gaussian", "mitchell", "lanczos"));
}

TEST(EnumWords, EveryWordLeadsBackToItsValue) {
  for (const EnumType* const type :
       {v1::Sampler_descriptor(), v1::Intersection_descriptor(), v1::DirectLight_descriptor(),
        v1::LightSelection_descriptor(), v1::Traversal_descriptor(), v1::AOV_descriptor(),
        v1::Bits_descriptor(), v1::Accelerator_descriptor()}) {
    EXPECT_EQ(static_cast<int>(words_of(*type).size()), type->value_count() - 1) << type->name();
    for (const std::string& word : words_of(*type)) {
      const absl::StatusOr<int> number = number_of(*type, word, "value");
      ASSERT_TRUE(number.ok()) << number.status();
      EXPECT_NE(*number, 0);
      EXPECT_EQ(word_of(*type, *number), word);
    }
    EXPECT_FALSE(number_of(*type, "unspecified", "value").ok()) << "nobody says that";
  }
}

TEST(EnumWords, WrongOnesAreAnsweredWithAllThereAreAndTheNearest) {
  EXPECT_EQ(
      value_of<v1::LightSelection>("unifrom").status().message(),
      "there is no light selection 'unifrom'; there is: auto, tree, mixed, power, uniform; did you mean "
      "'uniform'?");
  EXPECT_EQ(value_of<v1::AOV>("beauty").status().message(),
            absl::StrCat("there is no AOV 'beauty'; there is: ",
                         absl::StrJoin(words_of(*v1::AOV_descriptor()), ", ")));
}

TEST(EnumWords, ValuesOfANewerVersionAreRefusedByName) {
  v1::JobSpec spec;
  EXPECT_TRUE(check_settings(spec).ok());
  spec.mutable_content()->mutable_algorithms()->set_traversal(static_cast<v1::Traversal>(9));
  EXPECT_EQ(check_settings(spec).message(),
            "traversal is number 9, which this version does not know; it knows: packet, single");
  spec.mutable_content()->clear_algorithms();
  spec.mutable_view()->add_aovs(static_cast<v1::AOV>(77));
  EXPECT_THAT(std::string{check_settings(spec).message()}, HasSubstr("aovs is number 77"));
}

TEST(EnumWords, FieldsOfAnotherVersionAreRefusedByNumber) {
  v1::JobSpec spec;
  v1::MetropolisSettings& metropolis = *spec.mutable_content()->mutable_algorithms()->mutable_mlt();
  // The kind of mutations: jobs of earlier versions had it, and their pictures would be others.
  metropolis.GetReflection()->MutableUnknownFields(&metropolis)->AddVarint(5, 2);
  EXPECT_EQ(check_settings(spec).message(),
            "MetropolisSettings has field 5, which this version does not know");
}

}  // namespace
}  // namespace tessera::wire
