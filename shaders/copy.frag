// A resource as it is.
uniform vec2 u_texel;
uniform sampler2D u_image;

void main() { frag_color = SAMPLE(u_image, gl_FragCoord.xy * u_texel); }
