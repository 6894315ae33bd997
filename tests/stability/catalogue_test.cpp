/// The catalogue is complete: every row has a case or a test that exists, and every case has a row.
#include "benchmarks/reference/catalogue/catalogue.h"

#include "benchmarks/reference/catalogue/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
namespace fs = std::filesystem;

/// "`Suite.Name`" of all tests.
std::set<std::string> testNames()
{
    const std::regex test(R"(TEST(?:_F|_P)?\((\w+),\s+(\w+)\))");
    std::set<std::string> names;
    for (const auto& file : fs::recursive_directory_iterator(BULLET_CCD_SOURCES "/tests"))
    {
        if (file.path().extension() == ".cpp")
        {
            std::stringstream text;
            text << std::ifstream(file.path()).rdbuf();
            const std::string all = text.str();
            for (std::sregex_iterator found(all.begin(), all.end(), test), end; found != end;
                 ++found)
            {
                names.insert("`" + found->str(1) + "." + found->str(2) + "`");
            }
        }
    }
    return names;
}

/// Ids of all cases.
std::set<std::string> caseIds()
{
    std::set<std::string> ids;
    for (const RigidCase& tested : rigidCases())
    {
        ids.insert(tested.id);
    }
    for (const ArticulatedCase& tested : articulatedCases())
    {
        ids.insert(tested.id);
    }
    return ids;
}

TEST(Catalogue, EveryRowHasACaseOrATestThatExists)
{
    const std::set<std::string> ids = caseIds();
    const std::set<std::string> tests = testNames();
    int properties = 0;
    for (const CatalogueRow& row : catalogueRows())
    {
        SCOPED_TRACE(row.id);
        EXPECT_NE(row.group, "");
        EXPECT_NE(row.title, "");
        EXPECT_EQ(ids.contains(row.id), row.where == kIsCase);
        if (row.where != kIsCase)
        {
            EXPECT_TRUE(tests.contains(row.where)) << row.where;
            ++properties;
        }
    }
    EXPECT_GT(properties, 20);
    EXPECT_GE(std::count_if(ids.begin(), ids.end(), [](const auto& id) { return id[0] == 'N'; }),
              15);
}

TEST(Catalogue, EveryCaseHasARow)
{
    for (const std::string& id : caseIds())
    {
        EXPECT_NO_THROW((void)catalogueRow(id)) << id;
    }
}

TEST(Catalogue, RowsAreInOrder)
{
    EXPECT_TRUE(std::ranges::is_sorted(catalogueRows(), {}, &CatalogueRow::id));
}
}  // namespace
}  // namespace bullet_ccd::tests
