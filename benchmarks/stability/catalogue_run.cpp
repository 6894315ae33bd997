#include "benchmarks/stability/catalogue_run.h"

#include "benchmarks/reference/catalogue/relations.h"
#include "benchmarks/reference/oracles/brute_force_toi.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace bullet_ccd::tests
{
namespace
{
/// What a code that is asked for a time may be early.
constexpr double kAllowedTime = 1e-4;
/// Rounding of times of such a code.
constexpr double kLate = 1e-9;
/// Variants of a case that may time out; the rest is not asked then.
constexpr int kPatience = 2;
constexpr double kUlps = 4.0 * std::numeric_limits<double>::epsilon();

/// How early an answer may be.
double windowOf(const CaseAnswer& exact, double rounding, bool isOurs)
{
    const double lead = kUlps + 1.1 * leadTime(exact, exact.finest() + rounding);
    return isOurs ? lead : std::max(kAllowedTime, lead);
}

/// The legs one after the other, until one has an answer.
template <typename Case>
PeerAnswer answerLegs(const Method<Case>& method, const Variant<Case>& variant)
{
    PeerAnswer sum;
    for (const Leg<Case>& leg : variant.legs)
    {
        const PeerAnswer answer = method.run(leg.tested);
        sum.pairs += answer.pairs;
        sum.outcome = answer.outcome;
        sum.time = leg.begin + (leg.end - leg.begin) * answer.time;
        if (answer.outcome != PeerOutcome::Free)
        {
            break;
        }
    }
    return sum;
}

/// Distance at a time where the window cannot tell whether an early answer is tight: brute force.
double startingDistance(const RigidCase& tested, double t)
{
    return oracleDistanceAt(oracleBody(tested.scene.meshA, tested.scene.motionA),
                            oracleBody(tested.scene.meshB, tested.scene.motionB),
                            t);
}

/// No chain starts within the tolerance.
double startingDistance(const ArticulatedCase&, double)
{
    return 0.0;
}

/// A case that starts within the tolerance has no window; what is reported has to be that near.
template <typename Case>
void judgeTouching(const Case& tested, JudgedAnswer& judged)
{
    if (tested.answer.startsTouching && tested.answer.time && judged.verdict == CaseVerdict::Pass &&
        startingDistance(tested, judged.answer.time) >
            1.001 * tested.answer.finest() + roundingOf(tested))
    {
        judged.verdict = CaseVerdict::Inaccurate;
    }
}

template <typename Case>
struct AskedVariant
{
    Relation relation;
    Variant<Case> variant;
};

template <typename Case>
std::vector<AskedVariant<Case>> variantsToAsk(const Case& tested, const CatalogueOptions& options)
{
    std::vector<AskedVariant<Case>> asked;
    for (const Relation relation : kRelations)
    {
        for (Variant<Case>& variant : variantsOf(tested, relation))
        {
            asked.push_back({relation, std::move(variant)});
            if (options.firstVariantOnly)
            {
                break;
            }
        }
    }
    return asked;
}

template <typename Case>
void runRelations(const Case& tested,
                  const Method<Case>& method,
                  const JudgedAnswer& asItIs,
                  const std::vector<AskedVariant<Case>>& asked,
                  double limit,
                  MethodRow& row)
{
    std::vector<std::function<PeerAnswer()>> codes;
    for (const AskedVariant<Case>& one : asked)
    {
        codes.emplace_back([&] { return answerLegs(method, one.variant); });
    }
    const bool isOurs = method.owner == "ours";
    const std::vector<IsolatedAnswer> answers = runIsolated(codes, limit, kPatience);
    for (std::size_t i = 0; i < answers.size(); ++i)
    {
        const Variant<Case>& variant = asked[i].variant;
        double rounding = 0.0;
        for (const Leg<Case>& leg : variant.legs)
        {
            rounding = std::max(rounding, roundingOf(leg.tested));
        }
        const JudgedAnswer judged = judge(answers[i], variant.answer, rounding, isOurs);
        RelationCount& count = row.relations[nameOf(asked[i].relation)];
        ++count.asked;
        if (judged.verdict == CaseVerdict::Pass)
        {
            ++count.kept;
        }
        else
        {
            count.lost.push_back({tested.id, variant.name, judged.verdict});
        }
        if (isOurs && variant.answer.time && !variant.answer.startsTouching &&
            judged.verdict == CaseVerdict::Pass)
        {
            const double shift = std::abs(judged.answer.time - asItIs.answer.time) /
                                 windowOf(variant.answer, rounding, true);
            count.largestShift = std::max(count.largestShift, shift);
        }
    }
}

template <typename Case>
CatalogueTable run(const std::string& kind,
                   const std::vector<Case>& cases,
                   const std::vector<Method<Case>>& methods,
                   const CatalogueOptions& options)
{
    CatalogueTable table{.kind = kind, .methods = {}, .cases = {}};
    for (const Method<Case>& method : methods)
    {
        table.methods.push_back({method.name, method.owner, method.setting});
    }
    for (std::size_t number = 0; number < cases.size(); ++number)
    {
        const Case& tested = cases[number];
        if (!options.only.empty() && options.only != tested.id)
        {
            continue;
        }
        if (options.progress)
        {
            options.progress(tested.id, number, cases.size());
        }
        CaseRow row{.id = tested.id,
                    .kind = kind,
                    .title = tested.title,
                    .exact = tested.answer,
                    .rounding = roundingOf(tested)};
        const auto asked =
            options.relations ? variantsToAsk(tested, options) : std::vector<AskedVariant<Case>>{};
        for (std::size_t i = 0; i < methods.size(); ++i)
        {
            const Method<Case>& method = methods[i];
            JudgedAnswer judged{.note = method.notApplicable(tested)};
            if (judged.note.empty())
            {
                const std::function<PeerAnswer()> code = [&] { return method.run(tested); };
                judged = judge(runIsolated({&code, 1}, options.limit, 1)[0],
                               tested.answer,
                               roundingOf(tested),
                               method.owner == "ours");
                judgeTouching(tested, judged);
            }
            row.answers.push_back(judged);
            if (judged.verdict == CaseVerdict::Pass && !asked.empty())
            {
                runRelations(tested, method, judged, asked, options.variantLimit, table.methods[i]);
            }
        }
        table.cases.push_back(std::move(row));
    }
    return table;
}
}  // namespace

const char* nameOf(CaseVerdict verdict)
{
    constexpr std::array<const char*, 9> kNames{"pass",
                                                "inaccurate",
                                                "late",
                                                "missed",
                                                "false contact",
                                                "gave up",
                                                "crashed",
                                                "timed out",
                                                "not applicable"};
    return kNames[static_cast<std::size_t>(verdict)];
}

JudgedAnswer judge(const IsolatedAnswer& isolated,
                   const CaseAnswer& exact,
                   double rounding,
                   bool isOurs)
{
    JudgedAnswer judged{.verdict = CaseVerdict::Pass, .answer = isolated.answer};
    const PeerAnswer& answer = isolated.answer;
    if (isolated.ending != Ending::Answered)
    {
        judged.verdict =
            isolated.ending == Ending::Crashed ? CaseVerdict::Crashed : CaseVerdict::TimedOut;
    }
    else if (answer.outcome == PeerOutcome::GaveUp)
    {
        judged.verdict = CaseVerdict::GaveUp;
    }
    else if (!exact.time)
    {
        const bool isFalse =
            answer.outcome == PeerOutcome::Contact && exact.clearance > 1.001 * exact.finest();
        judged.verdict = isFalse ? CaseVerdict::FalseContact : CaseVerdict::Pass;
    }
    else if (answer.outcome == PeerOutcome::Free)
    {
        judged.verdict = CaseVerdict::Missed;
    }
    else
    {
        judged.error = answer.time - *exact.time;
        const double late = (isOurs ? kUlps : kLate) + leadTime(exact, rounding);
        if (!(judged.error <= late))  // not a number is late
        {
            judged.verdict = CaseVerdict::Late;
        }
        else if (!exact.startsTouching && judged.error < -windowOf(exact, rounding, isOurs))
        {
            judged.verdict = CaseVerdict::Inaccurate;
        }
    }
    return judged;
}

CatalogueTable runRigidCatalogue(const CatalogueOptions& options)
{
    return run("rigid", rigidCases(), rigidMethods(), options);
}

CatalogueTable runArticulatedCatalogue(const CatalogueOptions& options)
{
    return run("articulated", articulatedCases(), articulatedMethods(), options);
}
}  // namespace bullet_ccd::tests
