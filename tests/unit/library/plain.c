/* A program in C: two joints too few for a body, so that the library must say what is missing. */
#include "model/library/styled.h"

const char* PlainC(const char* weights);

const char* PlainC(const char* weights) {
  static char error[256];
  const char* names[] = {"hips", "head"};
  const int32_t parents[] = {-1, 0};
  const float offsets[] = {0, 1, 0, 0, 0.6F, 0};
  styled_body body = {sizeof body, 2, names, parents, offsets, NULL, NULL, NULL};
  styled_network* network = styled_load(weights, NULL, error, sizeof error);
  styled_performer* performer = styled_create(network, &body, error, sizeof error);
  styled_destroy(performer);
  styled_release(network);
  return error;
}
