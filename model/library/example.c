/* A performer who stands is restyled for two seconds: cc example.c -lstyled -lm; ./a.out STYLE */
#include <math.h>
#include <stdio.h>
#include <styled.h>

#define JOINTS 15
static const char* const names[JOINTS] = {
    "hips",         "spine",         "head",          "leftUpperArm", "leftLowerArm",
    "leftHand",     "rightUpperArm", "rightLowerArm", "rightHand",    "leftUpperLeg",
    "leftLowerLeg", "leftFoot",      "rightUpperLeg", "rightLowerLeg", "rightFoot"};
static const int32_t parents[JOINTS] = {-1, 0, 1, 1, 3, 4, 1, 6, 7, 0, 9, 10, 0, 12, 13};
static const float offsets[JOINTS][3] = {
    {0, 0.95F, 0},     {0, 0.15F, 0},  {0, 0.5F, 0},       {0.18F, 0.4F, 0}, {0.28F, 0, 0},
    {0.25F, 0, 0},     {-0.18F, 0.4F, 0}, {-0.28F, 0, 0},  {-0.25F, 0, 0},   {0.1F, -0.05F, 0},
    {0, -0.42F, 0},    {0, -0.4F, 0},  {-0.1F, -0.05F, 0}, {0, -0.42F, 0},   {0, -0.4F, 0}};

int main(int argc, char** argv) {
  char error[4096];
  styled_network* network = styled_load(NULL, NULL, error, sizeof error);
  const styled_body body = {sizeof body, JOINTS, names, parents, &offsets[0][0], NULL, NULL, NULL};
  styled_performer* performer = network ? styled_create(network, &body, error, sizeof error) : NULL;
  if (!performer) return fprintf(stderr, "%s\n", error), 1;
  const int32_t style = argc > 1 ? styled_find_style(network, argv[1]) : 1; /* 0 is neutral */
  const float weight = 1;
  if (styled_set(performer, &style, &weight, 1, 0.1F)) {
    fprintf(stderr, "no such style as %s; expected one of", argv[1]);
    for (int i = 0; i < styled_style_count(network); ++i) fprintf(stderr, " %s", styled_style_name(network, i));
    return fprintf(stderr, "\n"), 1;
  }
  float root[3], rotations[JOINTS][4];
  for (int frame = 0; frame < 240; ++frame) { /* 120 frames a second: the T-pose */
    for (int j = 0; j < JOINTS; ++j) for (int i = 0; i < 4; ++i) rotations[j][i] = i == 3;
    const float stand[3] = {0, 0.95F, 0};
    styled_frame(performer, frame * 8333333LL, stand, rotations[0], root, rotations[0], NULL);
  }
  for (int j = 0; j < JOINTS; ++j) {
    printf("%-14s turned by %5.1f degrees\n", names[j], 114.59F * acosf(fminf(1, fabsf(rotations[j][3]))));
  }
  styled_destroy(performer);
  styled_release(network);
  return 0;
}
