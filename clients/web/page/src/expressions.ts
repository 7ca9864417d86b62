// What an avatar shows of a frame's expressions: the client library's, which the page's tests pin.
export { expressionsOf } from 'styled-client';
