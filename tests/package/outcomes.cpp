// Tests that end in every way there is, for check_summary_test.py.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

TEST(Good, Passes) {}

TEST(Good, PassesAfterTextWithoutAnEnd)
{
    std::fputs("text", stdout);
}

TEST(Good, IsSkipped)
{
    GTEST_SKIP() << "nothing to test with";
}

TEST(Bad, Fails)
{
    FAIL() << "as it should";
}

TEST(Bad, Crashes)
{
    std::abort();
}

TEST(Bad, EndsTheProgram)
{
    std::exit(0);
}

TEST(Bad, Hangs)
{
    std::this_thread::sleep_for(std::chrono::hours(1));
}

TEST(Later, Passes) {}

TEST(Later, PassesToo) {}
